"""Measurements of the trade: what each model and tracer shows of `path`'s picture in a given time.

`path` is the exact model; the others are shortcuts to the same picture, set against its truth. They
have no solid angle and are off in exposure, which a user would turn up: their error is given as it
is and after one least-squares scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from harness.statistics.bias import relative_bias
from harness.statistics.estimate import Estimate, exactly, mean_of
from harness.statistics.intervals import Interval
from harness.statistics.metrics import Image, Truth, split_error
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
class Effort:
    """What images took: those of `image_spp` samples a pixel may have been timed at others."""

    image_spp: int
    seconds: Sequence[float]
    timed_spp: int


@dataclass(frozen=True, slots=True)
class Variant:
    """A tracer, a model and its settings as a way to the exact picture."""

    subject: Subject
    case: Case
    """what was turned and how the error was taken; empty for the exact model as the scene has it"""
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
        effort = Effort(images.spp, own.seconds, own.spp)
        found += variants_against(truth, subject, stack, effort, {})
    return found


def variants_against(
    truth: Truth, subject: Subject, stack: Image, effort: Effort, case: Case
) -> list[Variant]:
    """Images [K, h, w, 3] against the exact picture's truth, a shortcut's in both exposures."""
    if subject.model == EXACT:
        cases: list[tuple[Case, float]] = [(case, 1.0)]
    else:
        scale = least_squares_scale(stack, truth)
        cases = [
            (case | {"exposure": exposure, "truth": EXACT}, factor)
            for exposure, factor in (("raw", 1.0), ("scaled", scale))
        ]
    found = []
    for one, scale in cases:
        split = split_error(scale * stack, truth, relative=True)
        spread = split.variance_by_image
        found.append(
            Variant(
                subject,
                one,
                scale,
                relative_bias(scale * stack, truth),
                # The gate proves that the exact model's mean is right: its error is noise.
                exactly(0.0) if subject.model == EXACT else bias_squared_of(split),
                *ttuv_and_variance(spread, effort),
            )
        )
    return found


def ttuv_and_variance(variance_by_image: Image, effort: Effort) -> tuple[Estimate, Estimate]:
    """Time to unit variance, and the variance of one sample a pixel."""
    ttuv = time_to_unit_variance(
        variance_by_image, effort.image_spp, effort.seconds, effort.timed_spp
    )
    return ttuv, mean_of(variance_by_image * effort.image_spp)


def record_trade(
    recorder: Recorder,
    job: SceneJob,
    timed: dict[tuple[str, str], Timed],
    limit: Estimate | None = None,
) -> None:
    """Record error at a time, time and samples to an error, speed-ups and crossover times.

    limit: the squared bias of the scene's own depth limit, where it was measured; it is part of the
    exact model's error then. Nothing is recorded where the exact model has no truth or no images,
    or where the answer is known: those scenes are not timed.
    """
    if job.description.get("answers"):
        return
    if EXACT not in job.models or EXACT in job.untrue or not job.tracers(EXACT):
        return
    truth = job.truth(EXACT)
    exact_ones = variants_of(job, EXACT, truth, timed)
    if limit is not None:
        exact_ones = [replace(variant, bias_squared=limit) for variant in exact_ones]
    shortcuts = [
        variant
        for model in job.models
        if model != EXACT
        for variant in variants_of(job, model, truth, timed)
    ]
    for variant in [*exact_ones, *shortcuts]:
        record_budgets(recorder, variant)
    for variant in exact_ones:
        for other in exact_ones:
            if variant is not other and min(variant.ttuv.value, other.ttuv.value) > 0.0:
                to = {"to": other.subject.tracer}
                found = speed_up(variant.ttuv, other.ttuv)
                recorder.measure(variant.subject, "speed_up", found, to)
    for variant in shortcuts:
        record_bias(recorder, variant)
        for other in exact_ones:
            recorder.measure(
                variant.subject,
                "crossover_seconds",
                crossover_seconds(other.ttuv, variant.ttuv, variant.bias_squared),
                variant.case | {"to": other.subject.tracer},
            )


def record_budgets(recorder: Recorder, variant: Variant) -> None:
    """Record the errors at the budgets, and the time and samples to the targets."""
    subject, case = variant.subject, variant.case
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


def record_ttuv(recorder: Recorder, variant: Variant) -> None:
    """Record the relative time to unit variance of what is not a tracer's headline."""
    ttuv = positive_interval(variant.ttuv)
    recorder.measure(variant.subject, "relative_ttuv_seconds", ttuv, variant.case)


def record_bias(recorder: Recorder, variant: Variant) -> None:
    """Record how far a shortcut in one exposure is from the exact picture: mean, and pixels."""
    scaled = variant.case["exposure"] == "scaled"
    case = {key: value for key, value in variant.case.items() if key != "exposure"}
    recorder.measure(
        variant.subject,
        "relative_bias_scaled" if scaled else "relative_bias",
        variant.relative_bias,
        case,
    )
    if scaled:
        scale = exact(variant.scale, variant.relative_bias.n)
        recorder.measure(variant.subject, "exposure_scale", scale, case)
    record_ttuv(recorder, variant)
    bias_squared = variant.bias_squared.interval()
    recorder.measure(variant.subject, "relative_bias_squared", bias_squared, variant.case)
