"""The known answers: does every tracer's image show the radiance that the scene is known to have?

The answers are those of `reference/analytic`. A job writes them beside its images
(`harness.measure.answers`); here they are judged from the files of a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from harness.statistics.bias import Verdict
from harness.statistics.intervals import Interval, t_interval
from harness.tables.answers import LEVEL, answers_of, measured_radiance, relative_error
from harness.tables.read import SceneJob

DELTA = 0.003
"""The interval of the relative error must lie within plus or minus this."""


@dataclass(frozen=True, slots=True)
class AnswerVerdict:
    """One tracer's radiance of a scene with a known answer, in one model."""

    scene: str
    title: str
    model: str
    tracer: str
    """a name of the registry, or `truth`: Mitsuba's ground truth has to know the answer too"""
    expected: float
    """luminance of the answer"""
    measured: Interval
    """luminance of the images, at LEVEL"""
    error: Interval
    """measured / expected - 1, at LEVEL"""
    verdict: Verdict
    seeds_needed: int | None
    """images at which a verdict is expected; None once there is one"""
    note: str


def judge_error(error: Interval) -> Verdict:
    """PASS if the interval lies within plus or minus DELTA, FAIL if outside, else not enough."""
    if not math.isfinite(error.value) or error.lower >= DELTA or error.upper <= -DELTA:
        return Verdict.FAIL
    inside = error.lower > -DELTA and error.upper < DELTA
    return Verdict.PASS if inside else Verdict.NOT_ENOUGH_SAMPLES


def _seeds_needed(error: Interval) -> int | None:
    """Images at which the interval would leave the bound, its width falling as 1 / sqrt(n)."""
    if not math.isfinite(error.half_width):
        return None
    margin = max(abs(DELTA - abs(error.value)), 0.05 * DELTA)
    return math.ceil(error.n * (error.half_width / margin) ** 2)


def judge_answers(jobs: Iterable[SceneJob]) -> list[AnswerVerdict]:
    """Judge all tracers, and the ground truth itself, on all scenes with a known answer.

    Raises ResultsError for missing or damaged files.
    """
    verdicts = []
    for job in jobs:
        for model, expected in answers_of(job).items():
            for tracer, means in measured_radiance(job, model).items():
                error = relative_error(means, expected)
                verdict = judge_error(error)
                needed = _seeds_needed(error) if verdict is Verdict.NOT_ENOUGH_SAMPLES else None
                verdicts.append(
                    AnswerVerdict(
                        scene=job.name,
                        title=job.title,
                        model=model,
                        tracer=tracer,
                        expected=expected,
                        measured=t_interval(means, LEVEL),
                        error=error,
                        verdict=verdict,
                        seeds_needed=needed,
                        note="" if math.isfinite(error.value) else "pixels are not finite",
                    )
                )
    return verdicts


def describe_answers(verdicts: list[AnswerVerdict]) -> list[str]:
    """One line for each verdict, and one for all; none where no scene has a known answer."""
    if not verdicts:
        return []
    lines = []
    for row in verdicts:
        error = row.error
        text = (
            f"answer {row.expected:.6g}, measured {row.measured.value:.6g}: {error.value:+.3%} "
            f"[{error.lower:+.3%}, {error.upper:+.3%}] within ±{DELTA:.1%}"
        )
        if row.seeds_needed is not None:
            text += f" (about {row.seeds_needed} images)"
        name = f"{row.scene} {row.model} {row.tracer}"
        lines.append(
            f"{row.verdict.value:<18} {name:<40} {'; '.join(filter(None, [text, row.note]))}"
        )
    counts = {verdict: sum(row.verdict is verdict for row in verdicts) for verdict in Verdict}
    lines.append(
        f"known answers: {counts[Verdict.PASS]} pass, {counts[Verdict.FAIL]} fail, "
        f"{counts[Verdict.NOT_ENOUGH_SAMPLES]} not enough samples ({LEVEL:.0%} intervals)"
    )
    return lines
