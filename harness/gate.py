"""The gate: does every tracer's image agree with the ground truth, and with what it was?

Questions that all must be answered with yes: is the bias of the image mean proven to be small, does
no tile of any image differ, does the picture lie where it should, are the seeds independent, is
every pixel finite and not negative. A gate on the mean alone is blind: compensating local errors of
ten per cent pass it. What differs from the baseline is judged by `harness.regression`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.agreement import compare_images, tile_verdict, worst
from harness.answers import describe_answers, judge_answers
from harness.baseline import read_baseline
from harness.bounds import TESTS, Bound, GateSettings, settings_of
from harness.films import describe_films, films_exit_code
from harness.regression import Regression, describe_changes, judge_changes
from harness.slopes import describe_slopes, judge_slopes
from harness.snapshot import snapshots_of
from harness.statistics.bias import Equivalence, Verdict, exit_code_of
from harness.statistics.metrics import Defects, Truth, count_defects
from harness.statistics.tiles import TileTest
from harness.tables.eye_rays import eye_rays_of
from harness.tables.read import ImageSet, ResultsError, SceneJob, read_jobs
from harness.tables.study import read_study


@dataclass(frozen=True, slots=True)
class Judgement:
    """What the gate says of one tracer on one scene in one model."""

    scene: str
    model: str
    tracer: str
    verdict: Verdict
    bias: Equivalence | None
    """None where nothing could be compared"""
    tiles: TileTest | None
    tile_verdict: Verdict
    tile_level: float
    """p-value below which a tile is rejected"""
    defects: Defects | None
    note: str
    control: bool
    """True for Mitsuba against its own truth: a check of the statistics, not of a tracer"""

    @property
    def rejected(self) -> int:
        """Number of rejected tiles."""
        return 0 if self.tiles is None else int((self.tiles.p < self.tile_level).sum())


@dataclass(frozen=True, slots=True)
class Absent:
    """A tracer that was skipped on a scene in a model."""

    scene: str
    model: str
    tracer: str
    reason: str


@dataclass(frozen=True, slots=True)
class _Comparison:
    job: SceneJob
    model: str
    tracer: str
    bias: Equivalence | None
    tiles: TileTest | None
    defects: Defects | None
    note: str


def _compare(job: SceneJob, model: str, tracer: str, truth: Truth, bound: Bound) -> _Comparison:
    images = job.seeds(model, tracer)
    note = _failure(images)
    if images is None or not images.seeds:
        return _Comparison(job, model, tracer, None, None, None, note or "no images")
    stack = images.images.astype(np.float64)
    defects = count_defects(stack)
    if defects.non_finite or len(images.seeds) < 2:
        note = note or ("one image" if not defects.non_finite else "pixels are not finite")
        return _Comparison(job, model, tracer, None, None, defects, note)
    independent = not job.description.get("answers")
    found = compare_images(stack, images.spp, truth, bound, independent=independent)
    return _Comparison(job, model, tracer, found.bias, found.tiles, defects, note or found.note)


def _failure(images: ImageSet | None) -> str:
    if images is None:
        return ""
    if images.failures:
        return f"{len(images.failures)} seeds failed: {images.failures[0]}"
    return f"{images.dropped} samples are not finite and left out" if images.dropped else ""


def is_control(tracer: str) -> bool:
    """Whether a tracer is that of the truth: judging it checks the statistics, not the tracer."""
    return tracer.startswith("mitsuba")


def _judge(comparison: _Comparison, level: float) -> Judgement:
    bias, tiles, defects = comparison.bias, comparison.tiles, comparison.defects
    missing = Verdict.NOT_ENOUGH_SAMPLES
    of_tiles = missing if tiles is None else tile_verdict(tiles, level)
    verdicts = {bias.verdict if bias else missing, of_tiles}
    if comparison.note or (defects is not None and defects.any):
        verdicts.add(Verdict.FAIL)
    return Judgement(
        scene=comparison.job.name,
        model=comparison.model,
        tracer=comparison.tracer,
        verdict=worst(verdicts),
        bias=bias,
        tiles=tiles,
        tile_verdict=of_tiles,
        tile_level=level,
        defects=defects,
        note=comparison.note,
        control=is_control(comparison.tracer),
    )


def judge(jobs: list[SceneJob], settings: GateSettings) -> tuple[list[Judgement], list[Absent]]:
    """Compare every tracer that has images with the truth; list those that were skipped.

    The tiles of all images of `jobs` are one family. Raises ResultsError for missing or damaged
    files.
    """
    comparisons: list[_Comparison] = []
    absent: list[Absent] = []
    subjects = sum(len(job.tracers(model)) for job in jobs for model in job.models)
    strict = settings.strict(TESTS * subjects)
    for job in jobs:
        delta = settings.caustic_delta if job.caustic else settings.delta
        bound = Bound(delta, strict, settings.tile)
        for model in job.models:
            failed = {}
            for row in job.absent(model):
                if row.status == "failed":
                    failed[row.tracer] = row.reason
                else:
                    absent.append(Absent(job.name, model, row.tracer, row.reason))
            tracers = job.tracers(model)
            truth = job.truth(model) if tracers else None
            for tracer in dict.fromkeys([*tracers, *failed]):
                if tracer in failed or truth is None:
                    note = f"failed: {failed.get(tracer, 'there is no truth')}"
                    comparisons.append(_Comparison(job, model, tracer, None, None, None, note))
                else:
                    comparisons.append(_compare(job, model, tracer, truth, bound))
    family = sum(c.tiles.p.size for c in comparisons if c.tiles is not None)
    # As many again are compared with the baseline.
    level = settings.tile_level(2 * family)
    return [_judge(comparison, level) for comparison in comparisons], absent


def missing_tracers(judgements: list[Judgement], absent: list[Absent]) -> list[str]:
    """Tracers with images of a model in one scene, but no images and no reason in another."""
    known = {(row.scene, row.model, row.tracer) for row in [*judgements, *absent]}
    pairs = dict.fromkeys((scene, model) for scene, model, _ in sorted(known))
    return [
        f"{scene} {model} {tracer}: neither images nor a reason why not"
        for scene, model in pairs
        for tracer in sorted({row.tracer for row in judgements if row.model == model})
        if (scene, model, tracer) not in known
    ]


def describe(judgement: Judgement) -> str:
    """One line: the verdict, and what each of the three questions found."""
    parts = []
    bias = judgement.bias
    if bias is not None:
        interval = bias.bias
        text = (
            f"bias {interval.value:+.3%} [{interval.lower:+.3%}, {interval.upper:+.3%}]"
            f" within ±{bias.delta:.2%}: {bias.verdict.value}"
        )
        if bias.seeds_needed is not None:
            text += f" (about {bias.seeds_needed} seeds, {bias.batches_needed} batches)"
        parts.append(text)
    if judgement.tiles is not None:
        p, row, column = judgement.tiles.smallest
        parts.append(
            f"tiles: smallest p {p:.1e} at row {row}, column {column}, level "
            f"{judgement.tile_level:.1e}, visible error "
            f"{judgement.tiles.detectable(judgement.tile_level):.1%}: "
            f"{judgement.tile_verdict.value}"
        )
    if judgement.defects is not None:
        defects = judgement.defects
        parts.append(
            f"pixels: {defects.non_finite} not finite, {defects.negative} negative: "
            + ("FAIL" if defects.any else "PASS")
        )
    if judgement.note:
        parts.append(judgement.note)
    name = f"{judgement.scene} {judgement.model} {judgement.tracer}"
    return f"{judgement.verdict.value:<18} {name:<40} " + "; ".join(parts)


def exit_code(judgements: list[Judgement]) -> int:
    """0 if all pass, 1 if any fails, 2 if samples are missing and nothing fails.

    Mitsuba judged by its own truth can fail, but a sparse sample of it delays no verdict. Nothing
    judged is a failure.
    """
    if not judgements:
        return 1
    return exit_code_of(
        row.verdict for row in judgements if row.verdict is Verdict.FAIL or not row.control
    )


def worst_code(*codes: int) -> int:
    """The exit code of several verdicts: a failure before missing samples before a pass."""
    return max(codes, key=(0, 2, 1).index)


def compare_with_baseline(
    jobs: list[SceneJob],
    settings: GateSettings,
    baseline: Path | None,
    *,
    judge_speeds: bool = True,
) -> list[Regression]:
    """Compare a run with a baseline; empty without one. Raises ResultsError for damaged files."""
    before = read_baseline(baseline) if baseline is not None else []
    if not before:
        return []
    now = [row for job in jobs for row in snapshots_of(job, settings.tile)]
    caustic = {job.name for job in jobs if job.caustic}
    return judge_changes(now, before, settings, caustic, judge_speeds=judge_speeds)


def check(
    results_dir: Path,
    gate: Mapping[str, Any] | None = None,
    baseline: Path | None = None,
    *,
    judge_speeds: bool = True,
) -> int:
    """Print one line a scene, model and tracer, and a summary; returns the exit code.

    gate: as of GateSettings; without it, the settings that the run recorded. baseline: a folder
    that `./bench baseline` has written; without it, only the truth is asked. judge_speeds: False
    tells how speeds compare with the baseline's, and fails none. 0: all pass. 1: one fails, or
    there is nothing to judge. 2: not enough samples.
    """
    try:
        jobs = read_jobs(results_dir)
        rendered = [*jobs, *read_study(results_dir)]
        settings = settings_of(jobs) if gate is None else GateSettings(**gate)
        judgements, absent = judge(jobs, settings)
        answers = judge_answers(jobs)
        eye_rays = [row for job in jobs for row in eye_rays_of(job)]
        slopes = judge_slopes(results_dir / "measurements.csv", jobs)
        changes = compare_with_baseline(jobs, settings, baseline, judge_speeds=judge_speeds)
    except ResultsError as error:
        print(f"check: {error}", file=sys.stderr)
        return 1
    for row in judgements:
        print(describe(row))
    for skipped in absent:
        name = f"{skipped.scene} {skipped.model} {skipped.tracer}"
        print(f"{'skipped':<18} {name:<40} {skipped.reason}")
    missing = missing_tracers(judgements, absent)
    for line in missing:
        print(f"{Verdict.FAIL.value:<18} {line}")
    counts = {verdict: sum(row.verdict is verdict for row in judgements) for verdict in Verdict}
    tiles = sum(row.tiles.p.size for row in judgements if row.tiles is not None)
    level = next((row.tile_level for row in judgements), math.nan)
    print(
        f"{counts[Verdict.PASS]} pass, {counts[Verdict.FAIL] + len(missing)} fail, "
        f"{counts[Verdict.NOT_ENOUGH_SAMPLES]} not enough samples, {len(absent)} skipped; "
        f"{tiles} tiles, each tested at {level:.1e} so that the whole check errs with "
        f"probability {settings.alpha:g}"
    )
    for line in describe_answers(answers):
        print(line)
    for row in eye_rays:
        print(row.describe())
    for line in describe_slopes(slopes):
        print(line)
    for line in describe_films(rendered):
        print(line)
    for line in describe_changes(changes) if baseline else []:
        print(line)
    if not jobs:
        print("the run has no images: there is nothing to judge")
    if changes and not judge_speeds:
        print("baseline: speeds are told only, as was asked for")
    return worst_code(
        1 if missing else exit_code(judgements),
        exit_code_of(row.verdict for row in answers),
        0 if all(row.passed for row in eye_rays) else 1,
        exit_code_of(row.verdict for row in slopes),
        films_exit_code(rendered),
        exit_code_of(
            row.verdict
            for row in changes
            if row.verdict is Verdict.FAIL or not is_control(row.subject[-1])
        ),
    )
