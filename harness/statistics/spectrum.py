"""The error spectrum ensemble: at which scale of an image its error lies (Celarek et al. 2019)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harness.statistics.metrics import Image, Truth, luminance


def radial_frequencies(height: int, width: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Centres of rings of spatial frequency, [M] in cycles a pixel, and every bin's ring [h, w].

    Rings are one cycle of the shorter side wide and end at Nyquist's 0.5; bins beyond it, in the
    corners, and the mean of the image have ring -1.
    """
    radius = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None, :])
    step = 1.0 / min(height, width)
    ring = np.rint(radius / step).astype(np.int64)
    ring[(radius == 0.0) | (radius > 0.5)] = 0
    count = int(ring.max())
    return step * np.arange(1, count + 1), ring - 1


def error_spectra(images: Image, truth: Truth) -> NDArray[np.float64]:
    """Radial mean power of the relative error of each image: [K, M].

    |F(sqrt(w) (x - r))|^2 / P, F the discrete Fourier transform, x and r luminance, P the number of
    pixels and w = 1 / (r^2 + epsilon), the weight of relMSE. By Parseval its mean over all
    frequencies is the relMSE of the luminance, the truth's noise included; white noise is level.
    images: [K, h, w, 3].
    """
    reference = luminance(truth.mean)
    error = (luminance(images) - reference) / np.sqrt(reference**2 + truth.epsilon)
    power = np.abs(np.fft.fft2(error)) ** 2 / reference.size
    _, ring = radial_frequencies(*reference.shape)
    inside = ring.ravel() >= 0
    rings = ring.ravel()[inside]
    sums = np.stack([np.bincount(rings, one.ravel()[inside]) for one in power])
    return np.asarray(sums / np.bincount(rings))


def truth_spectrum(truth: Truth) -> float:
    """Power that the truth's own noise adds at every frequency, its pixels being independent."""
    light = luminance(truth.batches)
    variance = light.var(axis=0, ddof=1) / light.shape[0]
    return float((variance / (luminance(truth.mean) ** 2 + truth.epsilon)).mean())


def ensemble(spectra: NDArray[np.float64], shares: Sequence[float]) -> NDArray[np.float64]:
    """The runs that lie at some shares of all, sorted by their error: [len(shares), M].

    As Celarek et al. draw it: a run keeps its place at every frequency, so that the edge of a band
    is the same run throughout. spectra: [K, M].
    """
    runs = spectra[np.argsort(spectra.mean(axis=1), kind="stable")]
    places = np.rint(np.array(shares) * (len(runs) - 1)).astype(int)
    return np.asarray(runs[places])
