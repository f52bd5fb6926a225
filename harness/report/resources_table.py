"""Memory and energy: what a tracer takes beside its time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd

from harness.report import numbers
from harness.report.tables import Cell, Column, Table
from harness.tables.lookup import Measurement, Measurements
from harness.tables.read import tracer_order

LARGEST = ("peak_bytes", "bvh_bytes", "peak_queue_bytes")
"""Sizes of which the largest of all cases counts."""


def _largest(rows: Sequence[Measurement], quantity: str) -> float:
    values = [row.interval.value for row in rows if row.quantity == quantity and row.status == "ok"]
    return max(values, default=math.nan)


def _least_joules(rows: Sequence[Measurement]) -> Measurement | None:
    """The least energy of a benchmark of rays: that of the tracer's best traversal."""
    found = [
        row
        for row in rows
        if row.quantity == "joules" and row.engine == "replay" and row.status == "ok"
    ]
    return min(found, key=lambda row: row.interval.value, default=None)


def resources_table(measurements: Measurements) -> Table | None:
    """Scene, tracer: the most memory of any case, and the energy of tracing rays; None without."""
    wanted = {*LARGEST, "joules"}
    by_subject: dict[tuple[str, str], list[Measurement]] = {}
    for row in measurements.rows:
        if row.quantity in wanted and row.tracer != "truth":
            by_subject.setdefault((row.scene, row.tracer), []).append(row)
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    scenes = list(dict.fromkeys(scene for scene, _ in by_subject))
    ordered = sorted(by_subject, key=lambda key: (scenes.index(key[0]), tracer_order(key[1])))
    for scene, tracer in ordered:
        rows = by_subject[scene, tracer]
        sizes = {name: _largest(rows, name) for name in LARGEST}
        energy = _least_joules(rows)
        if energy is None and all(map(math.isnan, sizes.values())):
            continue
        reasons = [row.note for row in rows if row.quantity == "joules" and row.status != "ok"]
        note = "" if energy or not reasons else reasons[0]
        groups.setdefault(scene, []).append(
            [
                Cell(tracer, kind="tracer"),
                *(Cell(numbers.size(value)) for value in sizes.values()),
                Cell(numbers.MISSING)
                if energy is None
                else Cell(numbers.significant(energy.interval.value), energy.case),
                Cell(note, kind="text"),
            ]
        )
        records.append(
            {
                "scene": scene,
                "tracer": tracer,
                **sizes,
                "joules": energy.interval.value if energy else None,
                "joules_case": energy.case if energy else "",
                "note": note,
            }
        )
    if not records:
        return None
    columns = [
        Column("tracer", kind="text"),
        Column("process, at most"),
        Column("hierarchy"),
        Column("queue, at most"),
        Column("energy of tracing the rays once", "J"),
        Column("note", kind="text"),
    ]
    return Table("resources", columns, list(groups.items()), pd.DataFrame(records))
