"""What turning each knob costs and brings."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from harness.report import numbers
from harness.report.budget_table import crossover_cell
from harness.report.tables import Cell, Column, Table
from harness.report.turns import (
    extend,
    name_of_turn,
    only_turned,
    turn_order,
    turned_of,
)
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurement, Measurements
from harness.tables.read import SceneJob, model_order, tracer_order
from harness.tables.schema import parse_case
from harness.tables.trade import EXACT

QUANTITIES = (
    *("relative_bias", "relative_bias_scaled", "relative_bias_squared", "relative_variance"),
    *("image_seconds", "relative_ttuv_seconds", "speed_up"),
    *("crossover_seconds", "crossover_seconds_scaled"),
)


def knobs_table(measurements: Measurements, jobs: Sequence[SceneJob]) -> Table | None:
    """Scene, tracer, knob: bias, gain and crossover time; None where nothing was turned."""
    groups, records = [], []
    for job in jobs:
        turns = {
            (row.tracer, row.model, row.engine, only_turned(row.case)): row
            for row in measurements.rows
            if row.scene == job.name
            and row.quantity in {"relative_bias", "image_seconds"}
            and only_turned(row.case)
        }
        rows = []
        for (tracer, model, _, case), row in sorted(
            turns.items(), key=lambda item: _order(item[1])
        ):
            found = {
                name: interval
                for name, interval in _find(measurements, row, case).items()
                if interval is not None
            }
            reason = row.note if row.status != "ok" else ""
            turned = name_of_turn(turned_of(parse_case(case)))
            records.append(
                {"scene": job.name, "tracer": tracer, "model": model, "case": case}
                | {name: found[name].value if name in found else None for name in QUANTITIES}
                | {
                    f"{name}_{end}": getattr(found[name], end) if name in found else None
                    for name in ("crossover_seconds", "crossover_seconds_scaled", "speed_up")
                    for end in ("lower", "upper")
                }
                | {"note": reason}
            )
            rows.append(
                [
                    Cell(tracer, kind="tracer"),
                    Cell(f"{model}, {turned}", reason, kind="text"),
                    *_cells(found),
                ]
            )
        if rows:
            groups.append((job.name, rows))
    if not groups:
        return None
    columns = [
        Column("tracer", kind="text"),
        Column("model, turned to", kind="text"),
        Column("bias", "%"),
        Column("scaled", "%"),
        Column("bias squared"),
        Column("sooner", "times"),
        Column("T*"),
        Column("T*, scaled"),
    ]
    return Table("knobs", columns, groups, pd.DataFrame(records))


def _order(row: Measurement) -> tuple[object, ...]:
    turned = turned_of(parse_case(row.case))
    return (model_order(row.model), tracer_order(row.tracer), turn_order(turned))


def _find(measurements: Measurements, row: Measurement, case: str) -> dict[str, Interval | None]:
    where = {
        "scene": row.scene,
        "model": row.model,
        "tracer": row.tracer,
        "engine": row.engine,
    }
    truth = {} if row.model == EXACT else {"truth": EXACT}
    raw, scaled = (extend(case, exposure=one, **truth) for one in ("raw", "scaled"))
    mean = extend(case, **truth)

    def find(quantity: str, one: str) -> Interval | None:
        return measurements.find(quantity, case=one, **where)

    def of_images(quantity: str) -> Interval | None:
        cases = [
            one
            for one in measurements.cases(quantity, **where)
            if one.startswith(case) and one[len(case) :].startswith(";spp=")
        ]
        return find(quantity, cases[0]) if cases else None

    return {
        "relative_bias": find("relative_bias", mean),
        "relative_bias_scaled": find("relative_bias_scaled", mean),
        "relative_bias_squared": find("relative_bias_squared", raw),
        "relative_variance": of_images("relative_variance"),
        "image_seconds": of_images("image_seconds"),
        "relative_ttuv_seconds": find("relative_ttuv_seconds", raw)
        or find("relative_ttuv_seconds", case),
        "speed_up": find("speed_up", extend(case, to=row.tracer)),
        "crossover_seconds": find("crossover_seconds", extend(raw, to=row.tracer)),
        "crossover_seconds_scaled": find("crossover_seconds", extend(scaled, to=row.tracer)),
    }


def _cells(found: dict[str, Interval]) -> list[Cell]:
    missing = Cell(numbers.MISSING)
    changes = found.get("relative_bias_squared")
    if changes is not None and changes.lower == changes.upper == 0.0:
        missing = Cell(numbers.MISSING, "no bit changes")

    def percent(name: str) -> Cell:
        interval = found.get(name)
        if interval is None:
            return missing
        return Cell(numbers.percent(interval.value), numbers.percent_bounds(interval))

    bias, gain = found.get("relative_bias_squared"), found.get("speed_up")
    return [
        percent("relative_bias"),
        percent("relative_bias_scaled"),
        Cell(numbers.significant(bias.value), numbers.bounds(bias)) if bias else missing,
        Cell(numbers.significant(gain.value, 3), numbers.bounds(gain)) if gain else missing,
        *(
            crossover_cell(found[name]) if name in found else missing
            for name in ("crossover_seconds", "crossover_seconds_scaled")
        ),
    ]
