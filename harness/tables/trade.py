"""Measurements of the trade: what each model and tracer shows of `path`'s picture in a given time.

`path` is the exact model; the others are shortcuts to the same picture, set against its truth. They
have no solid angle and are off in exposure, which a user would turn up: their error is given as it
is and after one least-squares scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from harness.statistics.bias import relative_bias
from harness.statistics.estimate import Estimate, exactly, mean_of
from harness.statistics.intervals import Interval
from harness.statistics.metrics import Truth, split_error
from harness.statistics.timing import positive_interval, time_to_unit_variance
from harness.statistics.trade import (
    bias_squared_of,
    crossover_seconds,
    effort_to_error,
    error_at,
    least_squares_scale,
    speed_up,
)
from harness.tables.images import exact, subject_of
from harness.tables.read import SceneJob
from harness.tables.schema import Recorder, Subject
from harness.tables.times import Timed

EXACT = "path"
"""The model whose truth is the picture that all others are shortcuts to."""
BUDGETS = (0.1, 1.0, 10.0, 100.0)
"""Seconds that somebody may have for an image."""
TARGETS = (1e-1, 1e-2, 1e-3)
"""relMSE that somebody may ask of one."""
Case = dict[str, object]


@dataclass(frozen=True, slots=True)
class Variant:
    """A tracer and model as a way to the exact picture."""

    subject: Subject
    case: Case
    """how the error was taken; empty for the exact model"""
    scale: float
    """what the images were multiplied by"""
    relative_bias: Interval
    bias_squared: Estimate
    ttuv: Estimate
    sample_variance: Estimate
    """relative variance of one sample a pixel"""


def variants_of(
    job: SceneJob, model: str, truth: Truth, timed: dict[tuple[str, str], Timed]
) -> list[Variant]:
    """Every tracer of a model that was timed and has finite images of two seeds or more."""
    failed = {row.tracer for row in job.absent(model) if row.status == "failed"}
    found = []
    for tracer in job.tracers(model):
        images, own = job.seeds(model, tracer), timed.get((model, tracer))
        if tracer in failed or own is None or images is None or len(images.seeds) < 2:
            continue
        stack = images.images.astype(np.float64)
        if not np.isfinite(stack).all():
            continue
        subject = subject_of(job, model, tracer, own.engine)
        if model == EXACT:
            cases: list[tuple[Case, float]] = [({}, 1.0)]
        else:
            scale = least_squares_scale(stack, truth)
            cases = [({"exposure": "raw", "truth": EXACT}, 1.0)]
            cases += [({"exposure": "scaled", "truth": EXACT}, scale)]
        for case, scale in cases:
            split = split_error(scale * stack, truth, relative=True)
            found.append(
                Variant(
                    subject,
                    case,
                    scale,
                    relative_bias(scale * stack, truth),
                    # The gate proves that the exact model's mean is right: its error is noise.
                    exactly(0.0) if model == EXACT else bias_squared_of(split),
                    time_to_unit_variance(
                        split.variance_by_image, images.spp, own.seconds, own.spp
                    ),
                    mean_of(split.variance_by_image * images.spp),
                )
            )
    return found


def record_trade(recorder: Recorder, job: SceneJob, timed: dict[tuple[str, str], Timed]) -> None:
    """Record error at a time, time and samples to an error, speed-ups and crossover times.

    Nothing where the exact model has no truth or no images, or where the answer is known: those
    scenes are not timed.
    """
    if job.description.get("answers"):
        return
    if EXACT not in job.models or EXACT in job.untrue or not job.tracers(EXACT):
        return
    truth = job.truth(EXACT)
    exact_ones = variants_of(job, EXACT, truth, timed)
    shortcuts = [
        variant
        for model in job.models
        if model != EXACT
        for variant in variants_of(job, model, truth, timed)
    ]
    for variant in [*exact_ones, *shortcuts]:
        _record_budgets(recorder, variant)
    for variant in exact_ones:
        for other in exact_ones:
            if variant is not other and min(variant.ttuv.value, other.ttuv.value) > 0.0:
                to = {"to": other.subject.tracer}
                found = speed_up(variant.ttuv, other.ttuv)
                recorder.measure(variant.subject, "speed_up", found, to)
    for variant in shortcuts:
        _record_bias(recorder, variant)
        for other in exact_ones:
            recorder.measure(
                variant.subject,
                "crossover_seconds",
                crossover_seconds(other.ttuv, variant.ttuv, variant.bias_squared),
                variant.case | {"to": other.subject.tracer},
            )


def _record_budgets(recorder: Recorder, variant: Variant) -> None:
    subject, case = variant.subject, variant.case
    if case:
        recorder.measure(subject, "relative_ttuv_seconds", positive_interval(variant.ttuv), case)
    for seconds in BUDGETS:
        found = error_at(seconds, variant.bias_squared, variant.ttuv)
        recorder.measure(subject, "relmse_at", found.interval(), case | {"seconds": seconds})
    for target in TARGETS:
        aim = case | {"target": target}
        recorder.measure(
            subject,
            "seconds_to_relmse",
            effort_to_error(target, variant.bias_squared, variant.ttuv),
            aim,
        )
        recorder.measure(
            subject,
            "spp_to_relmse",
            effort_to_error(target, variant.bias_squared, variant.sample_variance),
            aim,
        )


def _record_bias(recorder: Recorder, variant: Variant) -> None:
    """Record how far a shortcut is from the exact picture: its mean, and every pixel."""
    scaled = variant.case["exposure"] == "scaled"
    case: Case = {"truth": EXACT}
    recorder.measure(
        variant.subject,
        "relative_bias_scaled" if scaled else "relative_bias",
        variant.relative_bias,
        case,
    )
    if scaled:
        scale = exact(variant.scale, variant.relative_bias.n)
        recorder.measure(variant.subject, "exposure_scale", scale, case)
    bias_squared = variant.bias_squared.interval()
    recorder.measure(variant.subject, "relative_bias_squared", bias_squared, variant.case)
