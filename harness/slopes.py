"""Do the errors of `path` fall as those of unbiased Monte Carlo do?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from harness.statistics.bias import Verdict
from harness.statistics.intervals import Interval
from harness.statistics.multiple import holm
from harness.tables.lookup import read_measurements
from harness.tables.read import SceneJob

MODEL = "path"
LEVEL = 0.01
"""Chance that any slope of the run is rejected though all are -1."""
HALF_WIDTH = 0.05
"""A wider interval tells neither bias nor a noisy truth from chance."""


@dataclass(frozen=True, slots=True)
class SlopeVerdict:
    """One tracer's slope on one scene."""

    scene: str
    tracer: str
    slope: Interval
    """95 %"""
    p_value: float
    verdict: Verdict


def judge_slopes(file: Path, jobs: Iterable[SceneJob]) -> list[SlopeVerdict]:
    """Judge every slope that was measured in `path`, those of scenes with a caustic excepted.

    Where light passes through glass first, a few pixels carry the error and a slope of this many
    images says little. Nor does that of a miniature run. The verdicts together reject a right
    tracer with probability `LEVEL`. file: measurements.csv of the run; none judges nothing. Raises
    ResultsError for a damaged one.
    """
    if not file.is_file():
        return []
    measurements = read_measurements(file)
    judged = {job.name for job in jobs if not (job.caustic or job.miniature)}
    found = []
    for row in measurements.rows:
        if (row.quantity, row.model, row.status) != ("slope", MODEL, "ok"):
            continue
        where = {"scene": row.scene, "model": MODEL, "tracer": row.tracer}
        p_value = measurements.find("slope_p_value", **where)
        if row.scene in judged and p_value is not None:
            found.append((row, p_value.value))
    rejected = holm([p_value for _, p_value in found], LEVEL)
    return [
        SlopeVerdict(row.scene, row.tracer, row.interval, p_value, _verdict(row.interval, rejects))
        for (row, p_value), rejects in zip(found, rejected, strict=True)
    ]


def _verdict(slope: Interval, rejected: bool) -> Verdict:
    if rejected:
        return Verdict.FAIL
    return Verdict.PASS if slope.half_width <= HALF_WIDTH else Verdict.NOT_ENOUGH_SAMPLES


def describe_slopes(verdicts: list[SlopeVerdict]) -> list[str]:
    """One line for each slope that does not pass, and one for all."""
    if not verdicts:
        return []
    lines = [
        f"{row.verdict.value:<18} {f'{row.scene} {MODEL} {row.tracer}':<40} "
        f"slope {row.slope.value:+.3f} ± {row.slope.half_width:.3f} (at most {HALF_WIDTH}), "
        f"p {row.p_value:.1e}"
        for row in verdicts
        if row.verdict is not Verdict.PASS
    ]
    widest = max(verdicts, key=lambda row: row.slope.half_width)
    excluding = sum(row.verdict is Verdict.FAIL for row in verdicts)
    lines.append(
        f"slopes of {MODEL} without caustics: {len(verdicts)}, of which {excluding} exclude -1 "
        f"(Holm, {LEVEL:.0%}); widest half-width {widest.slope.half_width:.3f} "
        f"({widest.scene} {widest.tracer})"
    )
    return lines
