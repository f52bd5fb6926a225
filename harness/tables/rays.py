"""Measurements of rays for their own sake: rates, ratios, sizes, visits and disagreement."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness.statistics.intervals import Interval, log_ratio_interval
from harness.statistics.timing import throughput
from harness.tables.images import exact
from harness.tables.read import read_json, run_name, scenes_of_section
from harness.tables.schema import Recorder, Subject

ENGINE = "replay"
MODEL = "none"
"""Model of what is not shaded."""

RATIOS_TO = ("embree", "mitsuba-cuda")
"""Tracers whose first way everybody's rays a second are compared with."""


@dataclass(frozen=True, slots=True)
class RayJob:
    """The files of one scene's benchmark of rays."""

    name: str
    title: str
    primitives: int
    provenance: Mapping[str, Any]
    classes: Sequence[Mapping[str, Any]]
    """the record of each class"""

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.provenance)

    @property
    def gpus(self) -> list[str]:
        """Names of the machine's GPUs."""
        found = self.provenance.get("machine", {}).get("gpus", [])
        return [str(gpu.get("name", "")) for gpu in found]


def read_ray_jobs(results_dir: Path) -> list[RayJob]:
    """Read what the benchmark of rays left of the run's scenes; raises ResultsError."""
    names = scenes_of_section(results_dir, "rays")
    return [_read_job(results_dir / "rays" / name) for name in names]


def _read_job(folder: Path) -> RayJob:
    description = read_json(folder / "scene.json")
    return RayJob(
        name=str(description["name"]),
        title=str(description["title"]),
        primitives=int(description["triangles"]) + int(description["spheres"]),
        provenance=read_json(folder / "provenance.json"),
        classes=[read_json(folder / f"{name}.json") for name in description["classes"]],
    )


def case_of(rays: str, traversal: str, **more: object) -> dict[str, object]:
    """The case of a row: tracers of others have no traversal to name."""
    return {"rays": rays, **({"traversal": traversal} if traversal else {}), **more}


def record_rays(recorder: Recorder, job: RayJob) -> None:
    """Record everything that came of the rays of one scene."""
    for record in job.classes:
        for row in record["variants"]:
            _record_variant(recorder, job, record, row)
        _record_ratios(recorder, job, record)
    _record_structures(recorder, job)


def _subject(job: RayJob, row: Mapping[str, Any]) -> Subject:
    return Subject(job.run, job.name, row["tracer"], MODEL, ENGINE, row["precision"])


def _record_variant(
    recorder: Recorder, job: RayJob, record: Mapping[str, Any], row: Mapping[str, Any]
) -> None:
    subject, case = _subject(job, row), case_of(record["rays"], row["traversal"])
    _record_rate(recorder, subject, case, row)
    if row["visits"] is not None:
        for name in ("nodes", "triangles"):
            mean = exact(row["visits"][name], row["rays"])
            recorder.measure(subject, f"{name}_per_ray", mean, case)
    if "wrong" in row:
        _record_disagreement(recorder, subject, case, row["wrong"])
        for other, share in row["differing"].items():
            _record_disagreement(recorder, subject, {**case, "to": other}, share)
        doubtful = 1e6 * record["ambiguous"] / record["sample"]
        recorder.measure(subject, "ambiguous_ppm", exact(doubtful, record["sample"]), case)
    if row["joules"] is not None:
        recorder.measure(subject, "joules", exact(row["joules"], 1), case)
    elif row["energy_reason"]:
        nothing, why = exact(math.nan, 0), row["energy_reason"]
        recorder.measure(subject, "joules", nothing, case, status="skipped", note=why)


def _record_rate(
    recorder: Recorder, subject: Subject, case: Mapping[str, object], row: Mapping[str, Any]
) -> None:
    status, note = row["status"], row["reason"]
    if status == "ok" and not row["seconds"]:
        status, note = "skipped", "takes one ray a call: its time would be that of the calls"
    if status != "ok":
        nothing = exact(math.nan, 0)
        recorder.measure(subject, "rays_per_second", nothing, case, status=status, note=note)
        return
    for repeat, seconds in enumerate(row["seconds"]):
        rate = row["rays"] / seconds
        recorder.sample(subject, "rays_per_second", rate, seed=repeat, spp=0, case=case)
    recorder.measure(subject, "rays_per_second", throughput(row["rays"], row["seconds"]), case)


def _record_disagreement(
    recorder: Recorder, subject: Subject, case: Mapping[str, object], share: Mapping[str, int]
) -> None:
    if share["rays"]:
        ppm = exact(1e6 * share["count"] / share["rays"], share["rays"])
        recorder.measure(subject, "disagreement_ppm", ppm, case)


def _record_ratios(recorder: Recorder, job: RayJob, record: Mapping[str, Any]) -> None:
    """Rays a second over those of the first way of each tracer of `RATIOS_TO`."""
    timed = [row for row in record["variants"] if row["seconds"] and row["status"] == "ok"]
    for other in RATIOS_TO:
        base = next((row for row in timed if row["tracer"] == other), None)
        if base is None:
            continue
        for row in timed:
            if row is not base:
                case = case_of(record["rays"], row["traversal"], to=other)
                ratio = ratio_of(row, base)
                recorder.measure(_subject(job, row), "speed_ratio", ratio, case)


def ratio_of(row: Mapping[str, Any], base: Mapping[str, Any]) -> Interval:
    """How many times more rays a second, by the geometric means over repeats."""
    own = [seconds / row["rays"] for seconds in row["seconds"]]
    others = [seconds / base["rays"] for seconds in base["seconds"]]
    return log_ratio_interval(others, own)


def _record_structures(recorder: Recorder, job: RayJob) -> None:
    """Build times and sizes, which are the same for every class of rays."""
    seen: set[tuple[str, str, str]] = set()
    for record in job.classes:
        for row in record["variants"]:
            key = (row["tracer"], row["traversal"], row["precision"])
            if key in seen or row["peak_bytes"] is None:
                continue
            seen.add(key)
            subject = _subject(job, row)
            case = {"traversal": row["traversal"]} if row["traversal"] else {}
            recorder.measure(subject, "peak_bytes", exact(row["peak_bytes"], 1), case)
            built = row["structure"]
            if built is not None:
                size = exact(built["size"] / job.primitives, job.primitives)
                recorder.measure(subject, "build_seconds", exact(built["build_seconds"], 1), case)
                recorder.measure(subject, "bytes_per_triangle", size, case)
