"""The table of eye rays: hits tracer by tracer beside the published count."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from harness.eye_rays import ALLOWED_PPM, EyeRayVerdict, NoEyeRays
from harness.report import numbers
from harness.report.tables import Cell, Column, Table
from harness.tables.eye_rays import eye_rays_of
from harness.tables.read import SceneJob


def _cells(row: EyeRayVerdict | NoEyeRays) -> list[Cell]:
    if isinstance(row, NoEyeRays):
        verdict = Cell("–") if row.passed else Cell("FAIL", kind="fail")
        missing = [Cell(numbers.MISSING)] * 4
        return [Cell(row.tracer, kind="tracer"), verdict, *missing, Cell(row.reason, kind="text")]
    furthest = max(row.differing.values(), default=0)
    return [
        Cell(row.tracer, kind="tracer"),
        Cell("PASS", kind="pass") if row.passed else Cell("FAIL", kind="fail"),
        Cell(f"{row.hits:,}", f"{row.published:,}"),
        Cell(numbers.percent(row.excess), f"±{100.0 * row.share:g}"),
        Cell(numbers.significant(row.ppm(row.disagreeing))),
        Cell(numbers.significant(row.ppm(furthest))),
        Cell("", kind="text"),
    ]


def eye_rays_table(jobs: Sequence[SceneJob]) -> Table | None:
    """Scene, tracer: the count, the published one, and what differs; None without such a scene."""
    groups, records = [], []
    for job in jobs:
        rows = eye_rays_of(job)
        if not rows:
            continue
        groups.append((job.name, [_cells(row) for row in rows]))
        for row in rows:
            record: dict[str, object] = {"scene": job.name, "tracer": row.tracer}
            if isinstance(row, NoEyeRays):
                records.append(record | {"verdict": row.status, "note": row.reason})
                continue
            records.append(
                record
                | {
                    "verdict": "PASS" if row.passed else "FAIL",
                    "rays": row.rays,
                    "hits": row.hits,
                    "published": row.published,
                    "share": row.share,
                    "disagreement_ppm": row.ppm(row.disagreeing),
                    "between_tracers_ppm": row.ppm(max(row.differing.values(), default=0)),
                    "allowed_ppm": ALLOWED_PPM,
                    "note": "",
                }
            )
    if not groups:
        return None
    columns = [
        Column("tracer", kind="text"),
        Column("verdict", kind="text"),
        Column("rays that hit, published"),
        Column("difference, allowed", "%"),
        Column("differ from double precision", "ppm"),
        Column("differ from a tracer, at most", "ppm"),
        Column("note", kind="text"),
    ]
    return Table("eye_rays", columns, groups, pd.DataFrame(records))
