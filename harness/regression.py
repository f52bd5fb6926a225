"""Is a run as good as the baseline? Image, variance and speed of every tracer, against before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from harness.agreement import worst
from harness.bounds import TESTS, Bound, GateSettings
from harness.snapshot import SPEED_OVER, Snapshot
from harness.statistics.bias import Equivalence, Verdict, judge_equivalence
from harness.statistics.change import (
    LEVEL,
    Speed,
    VarianceChange,
    judge_speed,
    judge_variance,
)
from harness.statistics.estimate import Estimate, combine, log_ratio_of_means, mean_of
from harness.statistics.intervals import Interval
from harness.statistics.tiles import rounding_bound, welch_from_moments

ROUNDING = 2.0**-16
"""Relative difference that float32 films and the digits of a baseline may leave."""


@dataclass(frozen=True, slots=True)
class Regression:
    """One tracer on one scene in one model, now and before."""

    subject: tuple[str, str, str]
    verdict: Verdict
    """of image and variance; a slower tracer fails where its speed is judged, an ambiguous time
    delays nothing"""
    bias: Equivalence | None
    """mean luminance now over before, less 1; None where nothing can be compared"""
    tile_p: float
    """smallest p-value of the tiles"""
    tile_level: float
    variance: VarianceChange | None
    speed: Speed | None
    """None where the tracer or the one it is set against was not timed on both sides"""
    speed_ratio: Interval | None
    """speed now over before, both as ratios to SPEED_OVER; the 90 % interval"""
    machine: str
    """what the baseline was timed on, where that is another machine; empty where it is the same"""
    note: str
    """why nothing could be compared"""

    @property
    def moved(self) -> bool:
        """Whether the images differ by more than rounding, though within what is allowed."""
        if self.bias is None or self.variance is None:
            return False
        return max(abs(self.bias.bias.value), abs(self.variance.ratio.value - 1.0)) > ROUNDING


def speed_change(now: Snapshot, before: Snapshot) -> Estimate | None:
    """Logarithm of the speed now over before, both relative to SPEED_OVER in their own run."""
    if min(now.log_seconds.size, before.log_seconds.size) < 2:
        return None
    return combine([(1.0, mean_of(before.log_seconds)), (-1.0, mean_of(now.log_seconds))])


def smallest_tile_p(now: Snapshot, before: Snapshot) -> float:
    """Smallest p-value of Welch's test of equal tiles; equal seeds only make it larger."""
    p = welch_from_moments(
        (now.tile_mean, now.tile_variance, len(now.seeds)),
        (before.tile_mean, before.tile_variance, len(before.seeds)),
        rounding_bound(max(now.spp, before.spp)),
    )
    return float(p.min())


def _incomparable(subject: tuple[str, str, str], note: str) -> Regression:
    nothing = Verdict.PASS
    return Regression(subject, nothing, None, 1.0, 0.0, None, None, None, "", note)


def judge_change(
    now: Snapshot,
    before: Snapshot,
    settings: GateSettings,
    bound: Bound,
    tile_level: float,
    *,
    judge_speeds: bool = True,
) -> Regression:
    """Compare a snapshot with that of before.

    Images of equal seeds are compared pair by pair, which holds as well where they are independent.
    A tracer that is slower on another processor is told, and fails nothing: instruction sets favour
    one tracer or the other. judge_speeds: False tells it on the same processor, too.
    """
    if now.frame != before.frame:
        sizes = " and ".join(f"{one.width}×{one.height}" for one in (now, before))
        note = f"images or tiles of other sizes than the baseline's ({sizes})"
        return _incomparable(now.subject, note)
    paired = now.seeds == before.seeds
    count = len(before.seeds)
    log = log_ratio_of_means(now.means, before.means, paired=paired)
    narrow, wide = (_less_one(log.ratio(level)) for level in (LEVEL, 1.0 - bound.strict))
    bias = judge_equivalence(narrow, bound.delta, count, wide)
    tile_p = smallest_tile_p(now, before)
    variance = judge_variance(
        log_ratio_of_means(now.variances, before.variances, paired=paired),
        settings.variance_margin,
        bound.strict,
    )
    change = speed_change(now, before)
    speed = None if change is None else judge_speed(change, settings.speed_margin, bound.strict)
    machine = "" if now.timed_on == before.timed_on else before.timed_on
    verdicts = {bias.verdict, variance.verdict}
    if tile_p < tile_level or (speed is Speed.SLOWER and judge_speeds and not machine):
        verdicts.add(Verdict.FAIL)
    return Regression(
        now.subject,
        worst(verdicts),
        bias,
        tile_p,
        tile_level,
        variance,
        speed,
        None if change is None else change.ratio(LEVEL),
        machine,
        "",
    )


def _less_one(ratio: Interval) -> Interval:
    return Interval(ratio.value - 1.0, ratio.lower - 1.0, ratio.upper - 1.0, ratio.n)


def judge_changes(
    now: Sequence[Snapshot],
    before: Sequence[Snapshot],
    settings: GateSettings,
    caustic: set[str],
    *,
    judge_speeds: bool = True,
) -> list[Regression]:
    """Compare every snapshot of a run with the baseline's; what the baseline lacks is left out.

    caustic: scenes with the wider bound. judge_speeds: as in `judge_change`. The levels are those
    of a run of which every tracer is compared with the truth and with the baseline.
    """
    known = {row.subject: row for row in before}
    strict = settings.strict(TESTS * len(now))
    tile_level = settings.tile_level(2 * sum(row.tile_mean.size for row in now))

    def bound(scene: str) -> Bound:
        delta = settings.caustic_delta if scene in caustic else settings.delta
        return Bound(delta, strict, settings.tile)

    return [
        judge_change(
            row,
            known[row.subject],
            settings,
            bound(row.scene),
            tile_level,
            judge_speeds=judge_speeds,
        )
        for row in now
        if row.subject in known
    ]


def describe_change(change: Regression) -> str:
    """One line: the verdict, and what image, variance and speed say."""
    parts = []
    if change.bias is not None:
        found = change.bias.bias
        text = (
            f"image {found.value:+.3%} [{found.lower:+.3%}, {found.upper:+.3%}] of the baseline's, "
            f"within ±{change.bias.delta:.2%}: {change.bias.verdict.value}"
        )
        if change.bias.seeds_needed is not None:
            text += f" (about {change.bias.seeds_needed} seeds)"
        parts.append(text)
        if change.tile_p < change.tile_level:
            parts.append(f"a tile differs, p {change.tile_p:.1e} < {change.tile_level:.1e}: FAIL")
    if change.variance is not None:
        found = change.variance.ratio
        text = (
            f"variance × {found.value:.3f} [{found.lower:.3f}, {found.upper:.3f}], "
            f"below {change.variance.margin:g}: {change.variance.verdict.value}"
        )
        if change.variance.seeds_needed is not None:
            text += f" (about {change.variance.seeds_needed} seeds)"
        parts.append(text)
    if change.speed is not None and change.speed_ratio is not None:
        found = change.speed_ratio
        parts.append(
            f"speed over {SPEED_OVER}'s × {found.value:.3f} [{found.lower:.3f}, "
            f"{found.upper:.3f}]: {change.speed.value}"
            + (f" (before on {change.machine})" if change.machine else "")
        )
    if change.note:
        parts.append(change.note)
    return f"{change.verdict.value:<18} {' '.join(change.subject):<40} " + "; ".join(parts)


def describe_changes(changes: Sequence[Regression]) -> list[str]:
    """One line for each failure, each want of samples and each slower tracer, and one for all."""
    if not changes:
        return ["baseline: nothing to compare with; ./bench baseline makes one"]
    lines = [
        describe_change(row)
        for row in changes
        if row.verdict is not Verdict.PASS or row.speed is Speed.SLOWER
    ]
    compared = [row for row in changes if not row.note]
    counts = {verdict: sum(row.verdict is verdict for row in compared) for verdict in Verdict}
    speeds = {speed: sum(row.speed is speed for row in compared) for speed in Speed}
    lines.append(
        f"baseline: {counts[Verdict.PASS]} pass, {counts[Verdict.FAIL]} fail, "
        f"{counts[Verdict.NOT_ENOUGH_SAMPLES]} not enough samples; speeds over {SPEED_OVER}'s: "
        + ", ".join(f"{count} {speed.value}" for speed, count in speeds.items())
    )
    others = {row.machine for row in compared if row.speed is not None and row.machine}
    if others:
        lines.append(
            f"baseline: speeds are no verdict here: it was timed on {'; '.join(sorted(others))}"
        )
    apart = len(changes) - len(compared)
    if apart:
        note = next(row.note for row in changes if row.note)
        lines.append(f"baseline: {apart} not comparable: {note}")
    return lines
