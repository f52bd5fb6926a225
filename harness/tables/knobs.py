"""Measurements of turned knobs: what depth limits, roulette, clamps, films and sample counts cost.

In `path` each turn is set against the same tracer's images of the same seeds without any limit, its
exact variant. The turns of `haste` are ways to the picture of `path`, as `haste` itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from harness.statistics.estimate import Estimate, exactly
from harness.statistics.intervals import Interval, median_interval
from harness.statistics.metrics import Image, Truth, split_error
from harness.statistics.paired import paired_relative_bias, paired_scale, squared_difference
from harness.statistics.trade import crossover_seconds, speed_up
from harness.tables.images import subject_of
from harness.tables.read import ImageSet, SceneJob
from harness.tables.schema import Recorder, Subject
from harness.tables.times import Timed
from harness.tables.trade import (
    EXACT,
    Case,
    Effort,
    Variant,
    record_bias,
    record_budgets,
    record_ttuv,
    ttuv_and_variance,
    variants_against,
    variants_of,
)

KNOBS = ("max_depth", "rr_depth", "clamp", "film", "light_samples", "ambient_samples")
"""Keys of a case that say what was turned."""
UNBIASED = frozenset({"rr_depth", "film", "light_samples", "ambient_samples"})
"""Knobs that change no mean: roulette divides by its probability, and more samples are more."""


@dataclass(frozen=True, slots=True)
class Turn:
    """Images of one setting of the knobs."""

    subject: Subject
    case: Case
    images: ImageSet

    @property
    def stack(self) -> Image:
        """Its images [K, h, w, 3]."""
        return self.images.images.astype(np.float64)

    @property
    def effort(self) -> Effort:
        """Its own images' times."""
        seconds = [float(record["seconds"]) for record in self.images.records]
        return Effort(self.images.spp, seconds, self.images.spp)


def turns_of(job: SceneJob, model: str) -> list[Turn]:
    """Turns of every tracer that have finite images of two seeds or more."""
    failed = {row.tracer for row in job.absent(model) if row.status == "failed"}
    return [
        turn
        for tracer in job.tracers(model)
        if tracer not in failed
        for case, images in job.knobs(model, tracer)
        for turn in [Turn(subject_of(job, model, tracer), case, images)]
        if len(images.seeds) > 1 and np.isfinite(images.images).all()
    ]


def exact_case(job: SceneJob) -> Case:
    """The turn of `path` that has no limit."""
    return {"max_depth": int(job.provenance["config"]["knobs"]["exact_depth"])}


def paired_variants(turn: Turn, exact: Turn, truth: Truth) -> list[Variant]:
    """A turn of `path` against the exact one, in both exposures; needs three seeds of both."""
    shared = sorted(set(turn.images.seeds) & set(exact.images.seeds))
    if len(shared) < 3:
        return []
    stack, other = (
        one.stack[[one.images.seeds.index(seed) for seed in shared]] for one in (turn, exact)
    )
    found = []
    for exposure in ("raw", "scaled"):
        scale = 1.0 if exposure == "raw" else paired_scale(stack, other, truth.weight)
        split = split_error(scale * turn.stack, truth, relative=True)
        found.append(
            Variant(
                turn.subject,
                turn.case | {"exposure": exposure},
                scale,
                paired_relative_bias(stack, other, scale),
                squared_difference(stack, other, truth.weight, scale),
                *ttuv_and_variance(split.variance_by_image, turn.effort),
            )
        )
    return found


def exact_variant(turn: Turn, truth: Truth) -> Variant:
    """The turn without a limit: all its error is noise."""
    stack = turn.stack
    spread = split_error(stack, truth, relative=True).variance_by_image
    nothing = Interval(0.0, 0.0, 0.0, len(stack))
    return Variant(
        turn.subject,
        turn.case,
        1.0,
        nothing,
        exactly(0.0),
        *ttuv_and_variance(spread, turn.effort),
    )


def record_knobs(
    recorder: Recorder, job: SceneJob, timed: dict[tuple[str, str], Timed]
) -> Estimate | None:
    """Record bias, variance, time, speed-up, errors and crossover time of every turn.

    Returns the squared bias of the scene's own depth limit, where it was measured.
    """
    _record_untaken(recorder, job)
    if EXACT not in job.models or EXACT in job.untrue or not job.tracers(EXACT):
        return None
    truth = job.truth(EXACT)
    limit = None
    for _, group in groupby(turns_of(job, EXACT), key=lambda turn: turn.subject.tracer):
        found = _record_path(recorder, job, list(group), truth)
        limit = limit or found
    turns = turns_of(job, "haste")
    if turns:
        _record_haste(recorder, turns, truth, variants_of(job, EXACT, truth, timed))
    return limit


def _record_path(
    recorder: Recorder, job: SceneJob, turns: Sequence[Turn], truth: Truth
) -> Estimate | None:
    exact_turn = next((turn for turn in turns if turn.case == exact_case(job)), None)
    if exact_turn is None:
        return None
    exact = exact_variant(exact_turn, truth)
    _record_effort(recorder, exact_turn, exact)
    record_ttuv(recorder, exact)
    record_budgets(recorder, exact)
    own = {"max_depth": job.description.get("settings", {}).get("max_depth")}
    limit = None
    for turn in turns:
        for variant in [] if turn is exact_turn else paired_variants(turn, exact_turn, truth):
            raw = variant.case["exposure"] == "raw"
            record_bias(recorder, variant)
            if raw:
                _record_effort(recorder, turn, variant)
                _record_speed_up(recorder, variant, exact)
            if raw and turn.case == own:
                limit = variant.bias_squared
            # The scene's own limit is what `path` has without a turn.
            if turn.case != own:
                record_budgets(recorder, _without_noise_of_bias(variant))
            _record_crossover(recorder, variant, exact)
    return limit


def _record_haste(
    recorder: Recorder, turns: Sequence[Turn], truth: Truth, exact_ones: Sequence[Variant]
) -> None:
    exact = {variant.subject.tracer: variant for variant in exact_ones}
    first: dict[str, Variant] = {}
    for turn in turns:
        for variant in variants_against(truth, turn.subject, turn.stack, turn.effort, turn.case):
            tracer = variant.subject.tracer
            record_bias(recorder, variant)
            record_budgets(recorder, variant)
            if variant.case["exposure"] == "raw":
                _record_effort(recorder, turn, variant)
                _record_speed_up(recorder, variant, first.setdefault(tracer, variant))
            if tracer in exact:
                _record_crossover(recorder, variant, exact[tracer])


def _record_crossover(recorder: Recorder, variant: Variant, exact: Variant) -> None:
    """Record until when the turn is better; not where it has changed no bit of any image."""
    case = variant.case | {"to": exact.subject.tracer}
    if variant.bias_squared.value == 0.0 and variant.bias_squared.error == 0.0:
        nothing = Interval(math.nan, math.nan, math.nan, variant.bias_squared.n)
        note = "the images are those of the exact variant"
        recorder.measure(
            variant.subject, "crossover_seconds", nothing, case, status="skipped", note=note
        )
        return
    found = crossover_seconds(exact.ttuv, variant.ttuv, variant.bias_squared)
    recorder.measure(variant.subject, "crossover_seconds", found, case)


def _without_noise_of_bias(variant: Variant) -> Variant:
    """A knob that changes no mean has no bias, whatever its images show."""
    if not UNBIASED & variant.case.keys():
        return variant
    return replace(variant, bias_squared=exactly(0.0))


def _record_effort(recorder: Recorder, turn: Turn, variant: Variant) -> None:
    spp = turn.images.spp
    case = turn.case | {"spp": spp}
    seconds = turn.effort.seconds
    for seed, value in zip(turn.images.seeds, seconds, strict=True):
        recorder.sample(turn.subject, "image_seconds", value, seed=seed, spp=spp, case=case)
    recorder.measure(turn.subject, "image_seconds", median_interval(seconds), case)
    scale = 1.0 / spp
    variance = variant.sample_variance.interval()
    recorder.measure(turn.subject, "relative_variance", variance.scaled(scale), case)


def _record_speed_up(recorder: Recorder, variant: Variant, base: Variant) -> None:
    """How much sooner than the base the same variance is reached: what an unbiased knob brings."""
    if min(variant.ttuv.value, base.ttuv.value) <= 0.0 or variant is base:
        return
    case = {key: value for key, value in variant.case.items() if key in KNOBS}
    to = {"to": base.subject.tracer}
    recorder.measure(variant.subject, "speed_up", speed_up(variant.ttuv, base.ttuv), case | to)


def _record_untaken(recorder: Recorder, job: SceneJob) -> None:
    """Record turns that a tracer has not, with the reason."""
    for row in job.untaken:
        case: Mapping[str, object] = row["case"]
        recorder.measure(
            subject_of(job, str(row["model"]), str(row["tracer"])),
            "relative_bias",
            Interval(math.nan, math.nan, math.nan, 0),
            case,
            status="skipped",
            note=str(row["reason"]),
        )
