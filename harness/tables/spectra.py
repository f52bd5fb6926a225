"""Measurements of the error spectrum: at which scale of an image its error lies."""

from __future__ import annotations

import numpy as np

from harness.statistics.intervals import t_interval
from harness.statistics.metrics import Truth
from harness.statistics.spectrum import ensemble, error_spectra, radial_frequencies
from harness.tables.images import exact
from harness.tables.read import ImageSet
from harness.tables.schema import Recorder, Subject

LEAST = 4
"""Fewest runs that make an ensemble."""
SHARES = (0.1, 0.9)
"""Of the runs, between which the ensemble's band lies."""
DIGITS = 6
"""Of a frequency, which names a row."""


def record_spectra(recorder: Recorder, subject: Subject, images: ImageSet, truth: Truth) -> None:
    """Record the error's power at every spatial frequency: its mean, and the ensemble's runs.

    Nothing of fewer than `LEAST` images, nor of images that are not finite or have one pixel a
    side.
    """
    stack = images.images.astype(np.float64)
    height, width = truth.mean.shape[:2]
    if len(images.seeds) < LEAST or min(height, width) < 2 or not np.isfinite(stack).all():
        return
    spectra = error_spectra(stack, truth)
    runs = ensemble(spectra, SHARES)
    frequencies, _ = radial_frequencies(height, width)
    for place, frequency in enumerate(frequencies):
        case: dict[str, object] = {"frequency": float(f"{frequency:.{DIGITS}g}")}
        case |= {"spp": images.spp}
        recorder.measure(subject, "error_power", t_interval(spectra[:, place]), case)
        for share, run in zip(SHARES, runs[:, place], strict=True):
            own = exact(float(run), len(images.seeds))
            recorder.measure(subject, "error_power_run", own, {**case, "quantile": share})
