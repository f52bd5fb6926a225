"""Two runs side by side: what changed beyond noise, between two commits or two machines.

Everything is read from measurements.csv, so that published runs can be compared as well. All
comparisons are one family: Holm's procedure keeps the chance of naming a single one that is noise.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from harness.bounds import GateSettings
from harness.measure.files import read_json
from harness.statistics.estimate import Estimate, combine, log_of
from harness.statistics.intervals import Interval, student_quantile
from harness.statistics.multiple import holm
from harness.tables.lookup import Measurement, Measurements, find_measurements, read_measurements
from harness.tables.provenance import Provenance, commits_of, records_of
from harness.tables.read import ResultsError
from harness.tables.schema import parse_case
from harness.whole_files import write_whole

ROUNDING = 2.0**-16
"""Relative difference that float32 films may leave."""
PRICES = ("feature_price", "determinism_price", "reallocation_price")
"""Ratios of times of one tracer, with something and without."""


@dataclass(frozen=True, slots=True)
class Question:
    """A quantity that two runs are asked about."""

    quantity: str
    title: str
    slack: float
    """change of its logarithm that is none"""
    worse: int
    """sign of a change for the worse, 0 where either is"""
    symmetric_log: bool
    """whether its interval is symmetric in the logarithm"""
    asks: Callable[[str], bool]
    """whether rows of a case are asked about"""


def questions(speed_margin: float) -> tuple[Question, ...]:
    """What is asked; speeds of two runs differ by `speed_margin` without a change of either."""

    def of_seeds(case: str) -> bool:
        return "seeds=" in case

    def of_speed(case: str) -> bool:
        # Of rays, both tracers that they are set against; of images Embree's alone.
        return case == "to=embree" or "rays" in parse_case(case)

    speed = math.log1p(speed_margin)
    return (
        Question("mean_luminance", "image", ROUNDING, 0, False, of_seeds),
        Question("relmse", "error", ROUNDING, 1, False, of_seeds),
        Question("relative_variance", "variance", ROUNDING, 1, False, of_seeds),
        Question("speed_ratio", "speed", speed, -1, True, of_speed),
        *(Question(price, "price", speed, 1, True, lambda _: True) for price in PRICES),
    )


@dataclass(frozen=True, slots=True)
class Difference:
    """One quantity of both runs."""

    title: str
    subject: str
    """scene, model, tracer, engine where it is not depth first, and what else tells it apart"""
    before: Interval
    after: Interval
    p: float
    """chance of so large a difference where nothing has changed"""
    kind: str
    """worse, better or changed, if it is one at all"""

    @property
    def factor(self) -> float:
        """After over before."""
        if self.before.value == 0.0:
            return 1.0 if self.after.value == 0.0 else math.inf
        return self.after.value / self.before.value


@dataclass(frozen=True, slots=True)
class Comparison:
    """What two runs have in common, and what of it changed."""

    changed: list[Difference]
    compared: int
    lost: list[str]
    """measured before, not now, and why"""
    gained: list[str]


def log_estimate(found: Interval, *, symmetric_log: bool) -> Estimate | None:
    """Logarithm of a positive measured value, its error from its 95 % interval; None without one.

    The interval was Student's with n - 1 degrees of freedom, or Welch's with up to 2 (n - 1): the
    larger error and the fewer degrees are taken.
    """
    if not (math.isfinite(found.half_width) and found.value > 0.0 and found.n > 1):
        return None
    if not symmetric_log:
        error = found.half_width / student_quantile(0.975, found.n - 1)
        return log_of(Estimate(found.value, error, found.n - 1.0, found.n))
    if found.lower <= 0.0:
        return None
    half = 0.5 * math.log(found.upper / found.lower)
    error = half / student_quantile(0.975, 2 * (found.n - 1))
    return Estimate(math.log(found.value), error, found.n - 1.0, found.n)


def _difference(question: Question, before: Measurement, after: Measurement) -> Difference | None:
    logs = [
        log_estimate(row.interval, symmetric_log=question.symmetric_log) for row in (after, before)
    ]
    subject = _subject(before)
    if logs[0] is None or logs[1] is None:
        # Black images have no logarithm; they differ where one of them is not black.
        values = (before.interval.value, after.interval.value)
        if 0.0 not in values or not all(map(math.isfinite, values)):
            return None
        p = 1.0 if values[0] == values[1] else 0.0
        change = values[1] - values[0]
    else:
        estimate = combine([(1.0, logs[0]), (-1.0, logs[1])])
        p, change = estimate.p_value(question.slack), estimate.value
    kind = "changed"
    if question.worse:
        kind = "worse" if change * question.worse > 0.0 else "better"
    return Difference(question.title, subject, before.interval, after.interval, p, kind)


def _subject(row: Measurement) -> str:
    engine = "" if row.engine == "depth_first" else f" {row.engine}"
    name = f"{row.scene} {row.model} {row.tracer}{engine}"
    told_apart = row.quantity in PRICES or "rays" in parse_case(row.case)
    return f"{name} {row.precision} {row.case}" if told_apart else name


def _defects(before: Measurement, after: Measurement) -> Difference:
    """Pixels that no renderer may produce: one more or less is a change."""
    values = before.interval.value, after.interval.value
    kind = "worse" if values[1] > values[0] else "better"
    p = 1.0 if values[0] == values[1] else 0.0
    title = before.quantity.removesuffix("_ppm").replace("_", " ")
    return Difference(title, _subject(before), before.interval, after.interval, p, kind)


def _tiles(before: Measurement, after: Measurement, alpha: float) -> Difference:
    """A tile that differs from the truth in one of the runs and does not in the other."""
    values = [min(row.interval.value * row.interval.n, 1.0) for row in (before, after)]
    differs = (values[0] < alpha) != (values[1] < alpha)
    kind = "worse" if values[1] < values[0] else "better"
    p = min(values) if differs else 1.0
    return Difference("tiles", _subject(before), before.interval, after.interval, p, kind)


def compare_runs(
    before: Measurements, after: Measurements, alpha: float, speed_margin: float
) -> Comparison:
    """Compare all that both runs measured alike; `alpha` is the chance of naming any noise."""

    def key(row: Measurement) -> tuple[str, ...]:
        subject = (row.scene, row.model, row.tracer, row.engine, row.precision)
        return (row.quantity, *subject, row.case)

    asked = {question.quantity: question for question in questions(speed_margin)}
    now = {key(row): row for row in after.rows}
    found: list[Difference] = []
    for row in before.rows:
        other = now.get(key(row))
        if other is None or row.status != "ok" or other.status != "ok":
            continue
        question = asked.get(row.quantity)
        if question is not None and question.asks(row.case):
            difference = _difference(question, row, other)
            found += [] if difference is None else [difference]
        elif row.quantity in {"non_finite_ppm", "negative_ppm"}:
            found.append(_defects(row, other))
        elif row.quantity == "tile_p_min" and row.tracer != "truth":
            found.append(_tiles(row, other, alpha))
    rejected = holm([row.p for row in found], alpha)
    changed = [row for row, rejects in zip(found, rejected, strict=True) if rejects]
    return Comparison(changed, len(found), _absent(before, after), _absent(after, before))


def _absent(first: Measurements, second: Measurements) -> list[str]:
    """Subjects with images in the first run and none in the second, and the second's reason."""

    def subjects(rows: Iterable[Measurement]) -> dict[str, None]:
        return dict.fromkeys(
            _subject(row)
            for row in rows
            if row.quantity == "relative_bias" and row.status == "ok" and not row.case
        )

    reasons: Mapping[str, str] = {
        _subject(row): f"{row.status}: {row.note}" for row in second.rows if row.status != "ok"
    }
    there = subjects(second.rows)
    return [
        f"{name} ({reasons.get(name, 'not measured')})"
        for name in subjects(first.rows)
        if name not in there
    ]


def _number(found: Interval) -> str:
    if not math.isfinite(found.half_width):
        return f"{found.value:.4g}"
    return f"{found.value:.4g} [{found.lower:.4g}, {found.upper:.4g}]"


def _machine(machine: Provenance) -> str:
    devices = [machine.get("processor"), *(gpu.get("name") for gpu in machine.get("gpus", []))]
    return ", ".join(str(device) for device in devices if device)


def describe_run(folder: Path) -> str:
    """One line on a run: its folder, its name, and the commits and machines of all its parts."""
    provenance = read_json(folder / "provenance.json") or {}
    records = records_of(provenance)
    machines = {_machine(one["machine"]) for one in records if "machine" in one}
    parts = [
        f"run {provenance.get('run', 'unnamed')}",
        f"commit {' and '.join(commits_of(provenance)) or 'unknown'}",
        *sorted(machines),
    ]
    return f"{folder}: {', '.join(parts)}"


COLUMNS = ("what", "scene, model, tracer", "before", "after", "factor", "p", "")


def table_of(comparison: Comparison) -> list[tuple[str, ...]]:
    """The changes as rows of text, the largest surprise first."""
    return [
        (
            row.title,
            row.subject,
            _number(row.before),
            _number(row.after),
            f"{row.factor:.4g}",
            f"{row.p:.1e}",
            row.kind,
        )
        for row in sorted(comparison.changed, key=lambda row: (row.title, row.p))
    ]


def summary_of(comparison: Comparison, alpha: float) -> str:
    """One sentence: how much was compared, and how much of it changed."""
    kinds = [row.kind for row in comparison.changed]
    parts = [f"{kinds.count(kind)} {kind}" for kind in ("worse", "better", "changed")]
    return (
        f"{comparison.compared} comparisons, {len(kinds)} beyond noise ({', '.join(parts)}); "
        f"{len(comparison.lost)} lost, {len(comparison.gained)} new. A single one of them is noise "
        f"with probability {alpha:g} at most (Holm)."
    )


def as_text(rows: list[tuple[str, ...]]) -> list[str]:
    """Lines of a table in columns, for a terminal."""
    if not rows:
        return []
    lines = [COLUMNS, *rows]
    widths = [max(len(line[place]) for line in lines) for place in range(len(COLUMNS))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    ]


def as_markdown(
    headings: list[str], comparison: Comparison, rows: list[tuple[str, ...]], summary: str
) -> str:
    """The report as a page of Markdown."""
    lines = ["# What changed beyond noise", "", *(f"- {text}" for text in headings), "", summary]
    if rows:
        lines += ["", f"| {' | '.join(COLUMNS)} |", "| --- " * len(COLUMNS) + "|"]
        lines += [f"| {' | '.join(row)} |" for row in rows]
    for title, names in (("Lost", comparison.lost), ("New", comparison.gained)):
        if names:
            lines += ["", f"## {title}", "", *(f"- {name}" for name in names)]
    return "\n".join(lines) + "\n"


def compare(before: Path, after: Path, out: Path | None, settings: GateSettings) -> int:
    """Print and write what changed from one results folder to another; returns the exit code.

    0: nothing beyond noise. 1: something changed, or was lost. 2: there is nothing to compare. out:
    a Markdown file; without it, comparison.md in `after`.
    """
    try:
        runs = [read_measurements(find_measurements(folder)) for folder in (before, after)]
        comparison = compare_runs(*runs, settings.alpha, settings.speed_margin)
        if comparison.compared == 0:
            raise ResultsError(f"{before} and {after} measured nothing alike")  # noqa: TRY301
    except ResultsError as error:
        print(f"compare: {error}", file=sys.stderr)
        return 2
    headings = [
        f"{name} is {describe_run(folder)}"
        for name, folder in (("before", before), ("after", after))
    ]
    rows, summary = table_of(comparison), summary_of(comparison, settings.alpha)
    path = out or after / "comparison.md"
    write_whole(path, as_markdown(headings, comparison, rows, summary))
    for line in [*headings, *as_text(rows), *(f"lost: {name}" for name in comparison.lost)]:
        print(line)
    print(summary)
    print(f"the report is {path}")
    return 1 if comparison.changed or comparison.lost else 0
