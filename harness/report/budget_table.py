"""At this budget use that: the best way to the exact picture, by time and by error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from harness.report import numbers
from harness.report.tables import Cell, Column, Table
from harness.report.turns import name_of_turn, turned_of
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurement, Measurements
from harness.tables.read import SceneJob, model_order, tracer_order
from harness.tables.schema import parse_case
from harness.tables.trade import BUDGETS, EXACT, TARGETS

MOST_NAMES = 3
"""Ways as good as the best that are named; the file has all."""


@dataclass(frozen=True, slots=True)
class Way:
    """A tracer and model, and what it costs or leaves."""

    tracer: str
    model: str
    interval: Interval
    turned: str = ""
    """what was turned, in words; nothing for the settings of the scene"""

    @property
    def name(self) -> str:
        """Tracer, model and what was turned."""
        own = f"{self.tracer} {self.model}"
        return f"{own}, {self.turned}" if self.turned else own


def ways(rows: Sequence[Measurement], quantity: str, key: str, value: float) -> list[Way]:
    """What was measured of one scene at one budget or target, the best first.

    Models other than the exact one are taken after their exposure was set right; `path` with a
    turned knob as it is.
    """
    found = []
    for row in rows:
        if row.quantity != quantity or row.status != "ok" or math.isnan(row.interval.value):
            continue
        case = parse_case(row.case)
        left_out = "scaled" if row.model == EXACT else "raw"
        if case.get(key) != value or case.get("exposure") == left_out:
            continue
        found.append(Way(row.tracer, row.model, row.interval, name_of_turn(turned_of(case))))
    return sorted(found, key=lambda way: (way.interval.value, tracer_order(way.tracer), way.name))


def as_good(found: Sequence[Way]) -> list[Way]:
    """Those whose interval reaches that of the best: nobody can tell them apart."""
    best = found[0].interval
    end = best.value if math.isnan(best.upper) else best.upper
    return [
        way
        for way in found[1:]
        if math.isfinite(way.interval.value)
        and (way.interval.lower if math.isfinite(way.interval.lower) else way.interval.value) <= end
    ]


def _cell(found: Sequence[Way], text: str) -> Cell:
    others = as_good(found)
    named = [f"or {way.name}" for way in others[:MOST_NAMES]]
    more = len(others) - len(named)
    faint = ", ".join([text, *named, *([f"and {more} more"] if more else [])])
    return Cell(found[0].name, faint, kind="prose")


def budget_table(measurements: Measurements, jobs: Sequence[SceneJob]) -> Table | None:
    """Scene by budget and target: what to use, and what it brings; None if nothing was measured."""
    questions = [
        *(("relmse_at", "seconds", seconds) for seconds in BUDGETS),
        *(("seconds_to_relmse", "target", target) for target in TARGETS),
    ]
    rows, records = [], []
    for job in jobs:
        own = [row for row in measurements.rows if row.scene == job.name]
        cells = [Cell(job.name, kind="text")]
        for quantity, key, value in questions:
            found = ways(own, quantity, key, value)
            if not found or not math.isfinite(found[0].interval.value):
                cells.append(Cell(numbers.MISSING))
                continue
            best = found[0].interval
            text = (
                f"relMSE {numbers.significant(best.value, 2)}"
                if key == "seconds"
                else numbers.seconds(best.value)
            )
            cells.append(_cell(found, text))
            alike = {way.name for way in as_good(found)}
            records += [
                {
                    "scene": job.name,
                    "quantity": quantity,
                    key: value,
                    "tracer": way.tracer,
                    "model": way.model,
                    "turned": way.turned,
                    "value": way.interval.value,
                    "lower": way.interval.lower,
                    "upper": way.interval.upper,
                    "rank": rank,
                    "as_good_as_the_best": rank == 1 or way.name in alike,
                }
                for rank, way in enumerate(found, 1)
            ]
        if any(cell.text != numbers.MISSING for cell in cells[1:]):
            rows.append(cells)
    if not rows:
        return None
    columns = [
        Column("scene", kind="text"),
        *(Column(f"in {seconds:g} s", kind="text") for seconds in BUDGETS),
        *(Column(f"to relMSE {target:g}", kind="text") for target in TARGETS),
    ]
    return Table("budget", columns, [("", rows)], pd.DataFrame(records))


def crossover_table(measurements: Measurements, jobs: Sequence[SceneJob]) -> Table | None:
    """Scene, model, tracer: bias of a shortcut, and until when it beats the exact model.

    None where no shortcut was measured. Against the exact model of the same tracer, since the trade
    of the models is asked, not that of the tracers; the file has all.
    """
    groups, records = [], []
    for job in jobs:
        rows = []
        found = [
            row
            for row in measurements.rows
            if (row.scene, row.quantity, row.status) == (job.name, "crossover_seconds", "ok")
            and not turned_of(parse_case(row.case))
        ]
        for row in sorted(
            found, key=lambda row: (model_order(row.model), tracer_order(row.tracer))
        ):
            case = parse_case(row.case)
            where = {"scene": row.scene, "model": row.model, "tracer": row.tracer}
            exposure = f"exposure={case['exposure']};truth={EXACT}"
            bias = measurements.find(
                "relative_bias_squared", case=exposure, engine=row.engine, **where
            )
            records.append(
                {
                    **where,
                    "exposure": case["exposure"],
                    "to": case["to"],
                    "relative_bias_squared": bias.value if bias else None,
                    "crossover_seconds": row.interval.value,
                    "crossover_seconds_lower": row.interval.lower,
                    "crossover_seconds_upper": row.interval.upper,
                }
            )
            if case["to"] != row.tracer or bias is None:
                continue
            rows.append(
                [
                    Cell(row.model, kind="text"),
                    Cell(row.tracer, kind="tracer"),
                    Cell(str(case["exposure"]), kind="text"),
                    Cell(numbers.significant(bias.value), numbers.bounds(bias)),
                    crossover_cell(row.interval),
                ]
            )
        groups.append((job.name, rows))
    if not any(rows for _, rows in groups):
        return None
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("exposure", kind="text"),
        Column("bias squared, relative"),
        Column(f"better than {EXACT} up to"),
    ]
    return Table("crossover", columns, groups, pd.DataFrame(records))


def crossover_cell(found: Interval) -> Cell:
    """T* with its interval; never where it is proven to be none."""
    if found.upper <= 0.0:
        return Cell("never")
    ends = [
        "0" if end <= 0.0 else "∞" if math.isinf(end) else numbers.seconds(end)
        for end in (found.lower, found.upper)
    ]
    text = "∞" if math.isinf(found.value) else numbers.seconds(max(found.value, 0.0))
    return Cell(text, f"[{', '.join(ends)}]")
