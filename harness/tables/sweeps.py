"""Measurements of scenes at their extremes: errors against closed forms."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.statistics.intervals import Interval
from harness.tables.read import read_json, run_name, section_of_run
from harness.tables.schema import Recorder, Subject
from harness.tables.stability import share_ppm


@dataclass(frozen=True, slots=True)
class SweepsJob:
    """What came of every hazard."""

    record: Mapping[str, Any]

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.record["provenance"])


def read_sweeps_job(results_dir: Path) -> SweepsJob | None:
    """Read it; None where the run's settings ask for none. Raises ResultsError."""
    if "sweeps" not in section_of_run(results_dir, "stability").get("suites", []):
        return None
    return SweepsJob(read_json(results_dir / "stability" / "sweeps.json"))


def record_sweeps(recorder: Recorder, job: SweepsJob) -> None:
    """Record the errors, and the samples that were left out for being no numbers."""
    nothing = Interval(math.nan, math.nan, math.nan, 0)
    for row in job.record["rows"]:
        subject = Subject(
            job.run, row["scene"], row["tracer"], "path", "depth_first", row["precision"]
        )
        ok, case, why = row["status"] == "ok", dict(row["case"]), row["reason"]
        error = Interval(**row["error"]) if ok else nothing
        recorder.measure(subject, "closed_form_error", error, case, status=row["status"], note=why)
        if "non_finite" in row:
            share = share_ppm(row["non_finite"], row["samples"])
            recorder.measure(subject, "non_finite_ppm", share, case)
