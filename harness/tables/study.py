"""Measurements that come from the study of packets: rates, queues, copies, laws and prices."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from harness.statistics.intervals import Interval, median_interval
from harness.statistics.launch_law import LaunchLaw, fit_launch_law
from harness.statistics.timing import speed_ratio, throughput
from harness.tables.images import exact
from harness.tables.read import model_order, read_json, run_name, scenes_of_study
from harness.tables.schema import Recorder, Subject

RAY_BYTES = 64
QUEUED = ("camera", "ambient", "bounce")
"""Classes of rays that a queue carries; shadow rays are settled where they are spawned."""
WORK = ("copy_seconds", "kernel_seconds", "queue_seconds", "allocation_seconds", "overlap")
COUNTED = ("launches", "bytes_moved", "peak_queue_bytes")

Case = dict[str, object]
Row = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Launches:
    """All timed renders of one engine, of one size of a launch."""

    tracer: str
    engine: str
    case: Mapping[str, object]
    rows: tuple[Row, ...]

    @property
    def seconds(self) -> list[float]:
        """Of each repeat."""
        return [float(row["seconds"]) for row in self.rows]

    @property
    def rays(self) -> dict[str, float]:
        """Rays of a render by class, `all` of them, and those that are `queued`."""
        per_sample = self.rows[0]["rays_per_sample"]
        rays = {name: n * self.rows[0]["samples"] for name, n in per_sample.items()}
        queued = sum(rays[name] for name in QUEUED)
        return {**rays, "all": sum(rays.values()), "queued": queued}

    @property
    def launch_rays(self) -> float:
        """Mean number of queued rays in a launch; of `streams` it depends on chance."""
        return float(median(self.rays["queued"] / row["launches"] for row in self.rows))

    @property
    def launch_seconds(self) -> list[float]:
        """Time of the mean launch of each repeat, with its copies."""
        return [float(row["seconds"] / row["launches"]) for row in self.rows]

    @property
    def variant(self) -> tuple[tuple[str, object], ...]:
        """What is not the size of a launch."""
        return tuple(sorted((k, v) for k, v in self.case.items() if k not in {"packet", "samples"}))


@dataclass(frozen=True, slots=True)
class StudyJob:
    """The files of the study of one scene in one model."""

    folder: Path
    name: str
    model: str
    title: str
    description: Row
    provenance: Row
    rows: Sequence[Row]
    work: Sequence[Row]

    @property
    def run(self) -> str:
        """Name of the run."""
        return run_name(self.provenance)

    def subject(self, tracer: str, engine: str) -> Subject:
        """The columns of the rows of an engine."""
        precision = next(str(r["precision"]) for r in self.work if r["tracer"] == tracer)
        return Subject(self.run, self.name, tracer, self.model, engine, precision)

    def case(self, case: Mapping[str, object]) -> Case:
        """A case of the study: its light samples keep it apart from the run's other sweeps."""
        return {**case, "light_samples": int(self.description["settings"]["light_samples"])}


def read_study(results_dir: Path) -> list[StudyJob]:
    """Read the studies of a run's settings; none where it has none. Raises ResultsError."""
    jobs = []
    for name, model in scenes_of_study(results_dir):
        folder = results_dir / "study" / name / model
        description = read_json(folder / "scene.json")
        jobs.append(
            StudyJob(
                folder,
                name,
                model,
                str(description.get("title") or name),
                description,
                read_json(folder / "provenance.json"),
                read_json(folder / "rows.json"),
                read_json(folder / "work.json"),
            )
        )
    return sorted(jobs, key=lambda job: model_order(job.model))


def group_launches(job: StudyJob) -> list[Launches]:
    """Group the timed rows by what was timed, in the order of the study."""
    groups: dict[str, list[Row]] = defaultdict(list)
    for row in job.rows:
        if row["status"] == "ok":
            groups[row["key"]].append(row)
    return [
        Launches(rows[0]["tracer"], rows[0]["engine"], rows[0]["case"], tuple(rows))
        for rows in groups.values()
    ]


def record_study(recorder: Recorder, job: StudyJob) -> None:
    """Record everything that one study has measured, or failed to."""
    launches = group_launches(job)
    for one in launches:
        _record_launches(recorder, job, one)
    for row in [*job.work, *job.rows]:
        if row["status"] != "ok":
            subject, case = job.subject(row["tracer"], row["engine"]), job.case(row["case"])
            nothing = exact(math.nan, 0)
            recorder.measure(
                subject, "launch_rays", nothing, case, status=row["status"], note=row["note"]
            )
    _record_work(recorder, job, {row["key"] for row in job.rows})
    _record_laws(recorder, job, launches)
    _record_prices(recorder, job, launches)
    for name, rate in (job.description.get("copies") or {}).items():
        tracer = next(row["tracer"] for row in job.work if "spans" in row or "overlap" in row)
        subject = job.subject(tracer, "none")
        recorder.measure(subject, "copy_rate", exact(rate, 1), {"copy": name})


def _record_launches(recorder: Recorder, job: StudyJob, one: Launches) -> None:
    subject, case = job.subject(one.tracer, one.engine), job.case(one.case)
    for row in one.rows:
        recorder.sample(
            *(subject, "seconds", float(row["seconds"])),
            seed=int(row["repeat"]),
            spp=int(row["spp"]),
            case={**case, "spp": int(row["spp"])},
        )
    for kind, count in one.rays.items():
        rate = throughput(count, one.seconds)
        recorder.measure(subject, "rays_per_second", rate, {**case, "rays": kind})
    recorder.measure(subject, "launch_rays", exact(one.launch_rays, len(one.rows)), case)
    if "packet" in one.case:
        fill = one.launch_rays / int(str(one.case["packet"]))
        recorder.measure(subject, "packet_fill", exact(fill, len(one.rows)), case)
    for name in COUNTED:
        values = [float(row[name]) for row in one.rows if name in row]
        if values:
            recorder.measure(subject, name, median_interval(values), case)


def _record_work(recorder: Recorder, job: StudyJob, timed: set[str]) -> None:
    for row in job.work:
        if row["status"] != "ok":
            continue
        subject, case = job.subject(row["tracer"], row["engine"]), job.case(row["case"])
        for name in (*WORK, "joules"):
            if name in row:
                recorder.measure(subject, name, exact(float(row[name]), 1), case)
        if row["key"] not in timed:
            # Only its queue was looked at.
            queue = exact(float(row["peak_queue_bytes"]), 1)
            recorder.measure(subject, "peak_queue_bytes", queue, case)


def fit_laws(launches: Sequence[Launches]) -> dict[tuple[object, ...], LaunchLaw | ValueError]:
    """Fit the law of every engine and way of taking packets, by tracer, engine and variant."""
    groups: dict[tuple[object, ...], list[Launches]] = defaultdict(list)
    for one in launches:
        groups[(one.tracer, one.engine, one.variant)].append(one)
    laws: dict[tuple[object, ...], LaunchLaw | ValueError] = {}
    for key, group in groups.items():
        try:
            laws[key] = fit_launch_law(
                [one.launch_rays for one in group], [one.launch_seconds for one in group]
            )
        except ValueError as error:
            laws[key] = error
    return laws


def _record_laws(recorder: Recorder, job: StudyJob, launches: Sequence[Launches]) -> None:
    plain = [one for one in launches if "film" not in one.case]
    for (tracer, engine, variant), law in fit_laws(plain).items():
        subject = job.subject(str(tracer), str(engine))
        case = job.case(dict(variant))  # type: ignore[call-overload]
        if isinstance(law, ValueError):
            nothing = exact(math.nan, 0)
            recorder.measure(subject, "r_inf", nothing, case, status="skipped", note=str(law))
            continue
        recorder.measure(subject, "launch_seconds", law.launch_seconds, case)
        recorder.measure(subject, "r_inf", law.r_inf, case)
        recorder.measure(subject, "n_half", law.n_half, case)
        recorder.measure(subject, "law_scatter", exact(law.scatter, law.points), case)
        recorder.measure(subject, "law_runs_p_value", exact(law.runs_p_value, law.points), case)
        kink = law.kink
        recorder.measure(subject, "law_kink_p_value", exact(kink.p_value, law.points), case)
        if kink.significant:
            place = exact(kink.rays, law.points)
            recorder.measure(subject, "law_kink_rays", place, case)
            steeper = kink.slope_after / kink.slope_before if kink.slope_before > 0 else math.inf
            recorder.measure(subject, "law_kink_ratio", exact(steeper, law.points), case)


def _record_prices(recorder: Recorder, job: StudyJob, launches: Sequence[Launches]) -> None:
    """Record what the integer film and the allocation for each packet cost, at equal work."""
    by_case = {(one.tracer, one.engine, frozenset(one.case.items())): one for one in launches}
    pairs = (
        ("determinism_price", "film", "float_atomic", None),
        ("reallocation_price", "allocation", "once", "per_packet"),
    )
    for quantity, key, base_value, own_value in pairs:
        for one in launches:
            if one.case.get(key) != base_value or (key != "film" and "film" in one.case):
                continue
            case = {k: v for k, v in one.case.items() if k != key}
            own_case = case if own_value is None else {**case, key: own_value}
            own = by_case.get((one.tracer, one.engine, frozenset(own_case.items())))
            if own is not None and len(own.rows) > 1 and len(one.rows) > 1:
                price = _price(own, one)
                recorder.measure(
                    job.subject(one.tracer, one.engine), quantity, price, job.case(case)
                )


def _price(own: Launches, base: Launches) -> Interval:
    """Time over the time without, at equal samples."""
    return speed_ratio(base.seconds, 1, own.seconds, 1)
