"""Two runs on machines of one kind: which ratios agree within their intervals.

Times differ with clocks and neighbours; a ratio of two renders that took turns should not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scipy import stats

from harness.statistics.intervals import Interval
from harness.statistics.multiple import holm
from harness.tables.lookup import Measurement, Measurements, read_measurements

RATIOS = ("speed_ratio", "determinism_price", "reallocation_price")
LEVEL = 0.05
"""Chance that any of the ratios is said to differ, where none does."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """One ratio in two runs."""

    first: Measurement
    second: Measurement
    p_value: float
    differs: bool

    def describe(self) -> str:
        """One line: what, in both runs, and the verdict."""
        row = self.first
        subject = f"{row.scene} {row.model} {row.tracer} {row.engine} {row.quantity} {row.case}"
        values = " and ".join(
            f"{one.interval.value:.3g} [{one.interval.lower:.3g}, {one.interval.upper:.3g}]"
            for one in (self.first, self.second)
        )
        verdict = "DIFFERS" if self.differs else "agrees"
        return f"{verdict} {subject}: {values}, p {self.p_value:.2g}"


def _error(interval: Interval) -> float:
    """Standard error of the logarithm, from an interval that is symmetric in it."""
    half = 0.5 * math.log(interval.upper / interval.lower)
    return half / float(stats.t.ppf(0.975, interval.n - 1))


def ratio_p_value(first: Interval, second: Interval) -> float:
    """Chance of two ratios so far apart, two-sided, where both are of one true ratio.

    Welch's t test of their logarithms (1947). An interval's standard error is taken back from its
    width with n - 1 degrees of freedom, fewer than a ratio of two times with n repeats each has.
    """
    errors = [_error(first) ** 2, _error(second) ** 2]
    total = sum(errors)
    apart = abs(math.log(first.value / second.value))
    if total == 0.0:
        return float(apart == 0.0)
    parts = zip(errors, (first.n - 1, second.n - 1), strict=True)
    degrees = total**2 / sum(error**2 / degree for error, degree in parts)
    return float(2.0 * stats.t.sf(apart / math.sqrt(total), degrees))


def compare_ratios(first: Measurements, second: Measurements) -> list[Comparison]:
    """Compare every ratio that both runs have with an interval; Holm's correction over them."""
    found = {_key(row): row for row in second.rows if _usable(row)}
    pairs = [(row, found[_key(row)]) for row in first.rows if _usable(row) and _key(row) in found]
    p_values = [ratio_p_value(a.interval, b.interval) for a, b in pairs]
    return [
        Comparison(a, b, p, differs)
        for (a, b), p, differs in zip(pairs, p_values, holm(p_values, LEVEL), strict=True)
    ]


def _usable(row: Measurement) -> bool:
    interval = row.interval
    known = math.isfinite(interval.lower) and math.isfinite(interval.upper)
    return row.quantity in RATIOS and row.status == "ok" and known and interval.n > 1


def _key(row: Measurement) -> Sequence[str]:
    return (row.quantity, row.scene, row.model, row.tracer, row.engine, row.case)


def compare_runs(first: Path, second: Path) -> int:
    """Print how the ratios of two runs' measurements.csv agree; 0 if all do, 1 otherwise.

    Raises ResultsError for a table that cannot be read.
    """
    rows = compare_ratios(read_measurements(first), read_measurements(second))
    for row in sorted(rows, key=lambda row: row.p_value):
        if row.differs:
            print(row.describe())
    differing = sum(row.differs for row in rows)
    print(
        f"{len(rows) - differing} of {len(rows)} ratios agree; together they err with probability "
        f"{LEVEL:g} (Holm)"
    )
    return int(differing > 0 or not rows)
