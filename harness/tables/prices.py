"""Measurements of what features cost: of kernels, and of renders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.statistics.intervals import Interval, log_ratio_interval, median_interval
from harness.statistics.timing import throughput
from harness.tables.images import exact
from harness.tables.read import read_json, run_name, scenes_of_section
from harness.tables.schema import Recorder, Subject

CUDA = "haste-cuda"
"""The tracer that has kernels."""
REQUIRED = "required"
OF_KERNEL = ("registers", "spill_bytes", "instructions", "occupancy")
UNKNOWN = Interval(math.nan, math.nan, math.nan, 0)


@dataclass(frozen=True, slots=True)
class PriceJob:
    """The files of one scene's prices."""

    name: str
    title: str
    description: Mapping[str, Any]
    provenance: Mapping[str, Any]
    compiled: Sequence[Mapping[str, Any]]
    timed: Sequence[Mapping[str, Any]]

    @property
    def engine(self) -> str:
        """The engine that was compiled and timed."""
        return str(self.provenance["config"]["features"]["engine"])

    def subject(self, model: str, tracer: str) -> Subject:
        """The columns of a row."""
        run = run_name(self.provenance)
        return Subject(run, self.name, tracer, model, self.engine, "watertight")


def read_price_jobs(results_dir: Path) -> list[PriceJob]:
    """Read what the pricing of features left of the run's scenes; raises ResultsError."""
    names = scenes_of_section(results_dir, "features")
    return [_read_job(results_dir / "features" / name) for name in names]


def _read_job(folder: Path) -> PriceJob:
    description = read_json(folder / "scene.json")
    return PriceJob(
        name=str(description["name"]),
        title=str(description["title"]),
        description=description,
        provenance=read_json(folder / "provenance.json"),
        compiled=read_json(folder / "compiled.json"),
        timed=read_json(folder / "timed.json"),
    )


def record_prices(recorder: Recorder, job: PriceJob) -> None:
    """Record what every set of features costs in kernels and in time."""
    for row in job.compiled:
        _record_kernel(recorder, job, row)
    for row in job.timed:
        _record_time(recorder, job, row)


def _record_kernel(recorder: Recorder, job: PriceJob, row: Mapping[str, Any]) -> None:
    subject, case = job.subject(row["model"], CUDA), {"features": row["features"]}
    size = exact(float(job.description["ray_bytes"]), 1)
    recorder.measure(subject, "bytes_per_ray", size, case)
    if row["status"] != "ok":
        for quantity in (*OF_KERNEL, "compile_seconds"):
            recorder.measure(
                subject, quantity, UNKNOWN, case, status=row["status"], note=row["reason"]
            )
        return
    for quantity in OF_KERNEL:
        if row[quantity] is not None:
            recorder.measure(subject, quantity, exact(float(row[quantity]), 1), case)
    seconds = median_interval(row["compile_seconds"])
    recorder.measure(subject, "compile_seconds", seconds, case)


def _record_time(recorder: Recorder, job: PriceJob, row: Mapping[str, Any]) -> None:
    subject, case = job.subject(row["model"], row["tracer"]), {"features": row["features"]}
    if row["status"] != "ok":
        recorder.measure(
            *(subject, "samples_per_second", UNKNOWN, case),
            status=row["status"],
            note=row["reason"],
        )
        return
    rate = throughput(row["samples"], row["seconds"])
    recorder.measure(subject, "samples_per_second", rate, case)
    base = next(
        other
        for other in job.timed
        if (other["model"], other["tracer"]) == (row["model"], row["tracer"])
        and other["features"] == REQUIRED
    )
    if row is not base:
        price = log_ratio_interval(row["seconds"], base["seconds"])
        recorder.measure(subject, "feature_price", price, case)
