"""Table of the known answers: expected, measured, error, tracer by tracer."""

from __future__ import annotations

import pandas as pd

from harness.answers import AnswerVerdict
from harness.report import numbers
from harness.report.tables import VERDICT_CLASS, Cell, Column, Table


def answers_table(verdicts: list[AnswerVerdict]) -> Table | None:
    """Model, tracer, radiance known and measured, error and verdict by scene; None without any."""
    if not verdicts:
        return None
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for row in verdicts:
        note = row.note
        if not note and row.seeds_needed is not None:
            note = f"about {row.seeds_needed} images needed"
        groups.setdefault(row.title, []).append(
            [
                Cell(row.model, kind="text"),
                Cell(row.tracer, kind="tracer"),
                Cell(row.verdict.value, kind=VERDICT_CLASS[row.verdict]),
                Cell(numbers.significant(row.expected, 6)),
                Cell(numbers.significant(row.measured.value, 6)),
                Cell(numbers.percent(row.error.value, 3), numbers.percent_bounds(row.error, 3)),
                Cell(note, kind="text"),
            ]
        )
        records.append(
            {
                "scene": row.scene,
                "model": row.model,
                "tracer": row.tracer,
                "verdict": row.verdict.value,
                "expected": row.expected,
                "measured": row.measured.value,
                "measured_lower": row.measured.lower,
                "measured_upper": row.measured.upper,
                "error": row.error.value,
                "error_lower": row.error.lower,
                "error_upper": row.error.upper,
                "images": row.error.n,
                "note": note,
            }
        )
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("verdict", kind="text"),
        Column("known luminance"),
        Column("measured"),
        Column("error, 99 % interval", "%"),
        Column("note", kind="text"),
    ]
    return Table("answers", columns, list(groups.items()), pd.DataFrame(records))
