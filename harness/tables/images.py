"""Measurements that come from images: agreement with the truth, error, variance, convergence."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harness.statistics import metrics
from harness.statistics.bias import relative_bias, weighted_relative_bias
from harness.statistics.convergence import fit_slope
from harness.statistics.intervals import Interval, median_interval, t_interval
from harness.statistics.metrics import Truth
from harness.statistics.robust import effective_pixels, quantile_interval
from harness.statistics.spectrum import truth_spectrum
from harness.statistics.tiles import TILE, compare_tiles, rounding_bound, sidak_level
from harness.tables.read import ImageSet, SceneJob
from harness.tables.schema import Recorder, Subject

PRECISIONS = {"haste-cuda": "watertight", "haste-cpu": "watertight", "embree": "robust"}
"""Arithmetic of the tracers' images; everything else is `native`."""

QUANTILES = (0.1, 0.5, 0.9)
"""Shares of the runs below which an error is given, beside its mean."""


def subject_of(job: SceneJob, model: str, tracer: str, engine: str = "depth_first") -> Subject:
    """The columns of a tracer's rows; its timed rows know the precision better than a default."""
    precision = PRECISIONS.get(tracer, "native")
    for row in job.timing:
        if row["tracer"] == tracer and row["model"] == model:
            precision = str(row.get("precision", precision))
    return Subject(job.run, job.name, tracer, model, engine, precision)


def exact(value: float, n: int) -> Interval:
    """A counted or minimal value that has no interval of its own."""
    return Interval(value, math.nan, math.nan, n)


def record_truth(recorder: Recorder, job: SceneJob, model: str, truth: Truth) -> None:
    """Record what is known of the truth itself."""
    subject = Subject(job.run, job.name, "truth", model, "depth_first", "native")
    batches = truth.batches.shape[0]
    means = metrics.luminance(truth.batches).mean(axis=(1, 2))
    recorder.measure(subject, "mean_luminance", t_interval(means))
    recorder.measure(subject, "truth_noise", exact(truth.relative_noise, batches))
    recorder.measure(subject, "truth_power", exact(truth_spectrum(truth), batches))


def record_seeds(
    recorder: Recorder, subject: Subject, images: ImageSet, truth: Truth, tile: int = TILE
) -> None:
    """Record agreement, error and variance of a tracer's independent images."""
    stack = images.images.astype(np.float64)
    count = len(images.seeds)
    defects = metrics.count_defects(stack)
    ppm = 1e6 / defects.pixels
    recorder.measure(subject, "non_finite_ppm", exact(defects.non_finite * ppm, count))
    recorder.measure(subject, "negative_ppm", exact(defects.negative * ppm, count))
    samples = images.spp * defects.pixels
    recorder.measure(subject, "dropped_ppm", exact(images.dropped * 1e6 / samples, count))
    if defects.non_finite:
        recorder.measure(
            subject,
            "relative_bias",
            exact(math.nan, count),
            status="failed",
            note=f"{defects.non_finite} pixels are not finite",
        )
        return
    by_seed: dict[str, NDArray[np.float64]] = {
        "mean_luminance": metrics.luminance(stack).mean(axis=(1, 2)),
        "mse": metrics.mse(stack, truth),
        "relmse": metrics.relmse(stack, truth),
        "smape": metrics.smape(stack, truth),
    }
    case: dict[str, object] = {"seeds": count, "spp": images.spp}
    for quantity, values in by_seed.items():
        for seed, value in zip(images.seeds, values, strict=True):
            recorder.sample(subject, quantity, value, seed=seed, spp=images.spp, case=case)
        recorder.measure(subject, quantity, t_interval(values), case)
    for quantile in QUANTILES:
        found = quantile_interval(by_seed["relmse"], quantile)
        recorder.measure(subject, "relmse_quantile", found, case | {"quantile": quantile})
    if count < 2:
        return
    _record_effective_pixels(recorder, subject, effective_pixels(stack), count)
    recorder.measure(subject, "relative_bias", relative_bias(stack, truth))
    recorder.measure(subject, "relative_bias", relative_bias(stack, truth, 0.9), {"level": 0.9})
    weighted = weighted_relative_bias(stack, truth)
    if weighted is not None:
        recorder.measure(subject, "relative_bias_weighted", weighted)
    tiles = compare_tiles(stack, truth.batches, rounding_bound(images.spp), tile)
    recorder.measure(subject, "tile_p_min", exact(tiles.smallest[0], tiles.p.size))
    detectable = tiles.detectable(sidak_level(tiles.p.size))
    recorder.measure(subject, "tile_detectable", exact(detectable, tiles.p.size))
    for quantity, relative in (("variance", False), ("relative_variance", True)):
        split = metrics.split_error(stack, truth, relative=relative)
        recorder.measure(subject, quantity, split.variance, case)
        if not relative:
            half = 1.96 * split.bias_squared_error
            bias = split.bias_squared
            recorder.measure(
                subject, "bias_squared", Interval(bias, bias - half, bias + half, count)
            )


def _record_effective_pixels(
    recorder: Recorder, subject: Subject, pixels: float, count: int
) -> None:
    none = math.isnan(pixels)
    recorder.measure(
        subject,
        "effective_pixels",
        exact(pixels, count),
        status="skipped" if none else "ok",
        note="nothing varies" if none else "",
    )


def record_convergence(
    recorder: Recorder, subject: Subject, sets: dict[int, ImageSet], truth: Truth
) -> None:
    """Record the error at several sample counts, and its slope."""
    errors: dict[int, NDArray[np.float64]] = {}
    for spp, images in sets.items():
        stack = images.images.astype(np.float64)
        if not np.isfinite(stack).all():
            continue
        errors[spp] = metrics.relmse(stack, truth)
        case = {"spp": spp}
        seconds = [float(record["seconds"]) for record in images.records]
        for seed, value, time in zip(images.seeds, errors[spp], seconds, strict=True):
            recorder.sample(subject, "relmse", value, seed=seed, spp=spp, case=case)
            recorder.sample(subject, "image_seconds", time, seed=seed, spp=spp, case=case)
        recorder.measure(subject, "relmse", t_interval(errors[spp]), case)
        recorder.measure(subject, "image_seconds", median_interval(seconds), case)
    try:
        fit = fit_slope(errors, truth.relative_noise)
    except ValueError as error:
        recorder.measure(subject, "slope", exact(math.nan, 0), status="skipped", note=str(error))
        return
    recorder.measure(subject, "slope", fit.slope)
    recorder.measure(subject, "slope_p_value", exact(fit.p_value, fit.slope.n))
