"""Measurements of stability: rays that pass between triangles, and hits that are none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scipy import stats

from harness.stability.cracks import QUANTILES
from harness.statistics.intervals import Interval
from harness.tables.images import exact
from harness.tables.rays import ENGINE, MODEL
from harness.tables.read import read_json, run_name, scenes_of_section, section_of_run
from harness.tables.schema import Recorder, Subject


@dataclass(frozen=True, slots=True)
class StabilityJob:
    """The files of one mesh."""

    name: str
    provenance: Mapping[str, Any]
    rows: list[Mapping[str, Any]]

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.provenance)


def read_stability_jobs(results_dir: Path) -> list[StabilityJob]:
    """Read what the tests of stability left of the run's scenes; raises ResultsError."""
    names = scenes_of_section(results_dir, "stability")
    return [_read_job(results_dir / "stability" / name) for name in names]


def _read_job(folder: Path) -> StabilityJob:
    summary = read_json(folder / "stability.json")
    rows: list[Mapping[str, Any]] = []
    for scale in summary["scales"]:
        rows += read_json(folder / f"scale-{scale:g}.json")["rows"]
    return StabilityJob(str(summary["scene"]), read_json(folder / "provenance.json"), rows)


@dataclass(frozen=True, slots=True)
class ModesJob:
    """What came of one scene in every precision."""

    name: str
    record: Mapping[str, Any]

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.record["provenance"])


def read_modes_jobs(results_dir: Path) -> list[ModesJob]:
    """Read what comparing the precisions left; as `read_stability_jobs`."""
    names = scenes_of_section(results_dir, "stability", "modes")
    folder = results_dir / "stability" / "modes"
    return [ModesJob(name, read_json(folder / f"{name}.json")) for name in names]


@dataclass(frozen=True, slots=True)
class SurfacesJob:
    """What came of rays that leave surfaces."""

    record: Mapping[str, Any]

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.record["provenance"])


def read_surfaces_job(results_dir: Path) -> SurfacesJob | None:
    """Read it; None where the run's settings ask for none. Raises ResultsError."""
    if "surfaces" not in section_of_run(results_dir, "stability").get("suites", []):
        return None
    return SurfacesJob(read_json(results_dir / "stability" / "surfaces.json"))


def share_ppm(count: int, of: int) -> Interval:
    """`count` of `of` per million, with the exact 95 % interval of Clopper and Pearson (1934)."""
    if not of:
        return Interval(math.nan, math.nan, math.nan, 0)
    interval = stats.binomtest(count, of).proportion_ci(method="exact")
    return Interval(1e6 * count / of, 1e6 * interval.low, 1e6 * interval.high, of)


def record_stability(recorder: Recorder, job: StabilityJob) -> None:
    """Record everything that came of one mesh."""
    for row in job.rows:
        subject = Subject(job.run, job.name, row["tracer"], MODEL, ENGINE, row["precision"])
        case = {"aim": row["aim"], "eye": float(row["eye"]), "scale": float(row["scale"])}
        if row["traversal"]:
            case["traversal"] = row["traversal"]
        if row["status"] != "ok":
            nothing, why = share_ppm(0, 0), row["reason"]
            recorder.measure(subject, "cracks_ppm", nothing, case, status=row["status"], note=why)
            continue
        judged, rays = row["judged"], row["rays"]
        if not judged:
            why = "none of its rays surely meets what it is aimed at"
            recorder.measure(
                subject, "cracks_ppm", share_ppm(0, 0), case, status="skipped", note=why
            )
            continue
        recorder.measure(subject, "cracks_ppm", share_ppm(row["lost"], judged), case)
        recorder.measure(subject, "left_out_ppm", share_ppm(rays - judged, rays), case)
        at_outline = row["met"] - judged
        for name, count, of in (
            ("outline_ppm", row["at_outline"], at_outline),
            ("false_hits_ppm", row["denied"], row["hits"]),
        ):
            if of:
                recorder.measure(subject, name, share_ppm(count, of), case)
        for quantile, ulp in zip(QUANTILES, row["ulp"] or (), strict=False):
            error = exact(ulp, row["hits"])
            recorder.measure(subject, "t_error_ulp", error, {**case, "quantile": quantile})


def record_modes(recorder: Recorder, job: ModesJob) -> None:
    """Record how the precisions of one scene differ."""
    model, samples = job.record["model"], job.record["samples"]
    for row in job.record["rows"]:
        subject = Subject(job.run, job.name, row["tracer"], model, "depth_first", row["precision"])
        if row["status"] != "ok":
            nothing, why = share_ppm(0, 0), row["reason"]
            recorder.measure(subject, "paired_bias", nothing, status=row["status"], note=why)
            continue
        case = {"against": row["against"]}
        non_finite = share_ppm(row["non_finite"], samples)
        recorder.measure(subject, "non_finite_ppm", non_finite, case)
        if row["samples_per_second"] is not None:
            recorder.measure(subject, "paired_rate", exact(row["samples_per_second"], 1), case)
        if row["precision"] == row["against"]:
            continue
        recorder.measure(subject, "paired_bias", Interval(**row["bias"]), case)
        recorder.measure(subject, "diverged_ppm", share_ppm(row["diverged"], samples), case)
        if row["speed"] is not None:
            recorder.measure(subject, "paired_speed", exact(row["speed"], 1), case)


def record_surfaces(recorder: Recorder, job: SurfacesJob) -> None:
    """Record self-hits and leaks."""
    for row in job.record["rows"]:
        scene = {"self_hits_ppm": "tilted-mirror", "leaks_ppm": "floor-under-lid"}[row["quantity"]]
        subject = Subject(job.run, scene, row["tracer"], "path", "depth_first", row["precision"])
        ok = row["status"] == "ok"
        share = share_ppm(row["count"], row["of"]) if ok else share_ppm(0, 0)
        case, why = dict(row["case"]), row["reason"]
        recorder.measure(subject, row["quantity"], share, case, status=row["status"], note=why)
