"""Measurements that come from times: throughput, ratios, split times, efficiency."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.statistics.intervals import Interval, median_interval
from harness.statistics.metrics import Truth, split_error
from harness.statistics.timing import (
    efficiency,
    positive_interval,
    speed_ratio,
    throughput,
    time_to_unit_variance,
)
from harness.tables.images import exact, subject_of
from harness.tables.read import ImageSet, SceneJob
from harness.tables.schema import Recorder, SchemaError, load_list

RAY_CLASSES = ("camera", "shadow", "ambient", "bounce")
RATIOS_TO = ("embree", "mitsuba-llvm")
"""Tracers that everybody's speed is compared with."""

NOT_QUANTITIES = frozenset({"repeat", "seed", "spp", "non_finite"})
"""Numbers of a timed row that are not measured quantities of their own."""

ONCE = frozenset(
    {"load_seconds", "build_seconds", "compile_seconds", "upload_seconds", "warm_seconds"}
)
"""Times taken once a process, repeated in each of its rows."""


@dataclass(frozen=True, slots=True)
class Timed:
    """Repeats of one timed render."""

    tracer: str
    model: str
    engine: str
    case: Mapping[str, object]
    spp: int
    rows: tuple[Mapping[str, Any], ...]

    @property
    def seconds(self) -> list[float]:
        """The time of each repeat."""
        return [float(row["seconds"]) for row in self.rows]

    @property
    def rays(self) -> dict[str, int] | None:
        """Rays of one render by class and `all`, or None where they were not counted."""
        counts = self.rows[0].get("rays")
        if counts is None:
            return None
        rays = {name: int(counts[name]) for name in RAY_CLASSES}
        return {**rays, "all": sum(rays.values())}


def group_times(job: SceneJob) -> list[Timed]:
    """Group the timed rows of a scene by what was timed."""
    groups: dict[tuple[str, str, str, str, int], list[Mapping[str, Any]]] = defaultdict(list)
    for row in job.timing:
        if row.get("status", "ok") == "ok":
            case = repr(sorted(row.get("case", {}).items()))
            key = (row["tracer"], row["model"], row["engine"], case, int(row["spp"]))
            groups[key].append(row)
    return [
        Timed(tracer, model, engine, rows[0].get("case", {}), spp, tuple(rows))
        for (tracer, model, engine, _, spp), rows in groups.items()
    ]


def headline(times: list[Timed]) -> dict[tuple[str, str], Timed]:
    """The timed render of each tracer and model that was not part of a sweep."""
    return {(timed.model, timed.tracer): timed for timed in reversed(times) if not timed.case}


def record_times(recorder: Recorder, job: SceneJob, times: list[Timed]) -> None:
    """Record times, throughput, ray rates, split times and sizes of all timed renders."""
    pixels = job.width * job.height
    for timed in times:
        subject = subject_of(job, timed.model, timed.tracer, timed.engine)
        case, samples = dict(timed.case), timed.spp * pixels
        for row in timed.rows:
            recorder.sample(
                subject,
                "seconds",
                float(row["seconds"]),
                seed=int(row["repeat"]),
                spp=timed.spp,
                case={**case, "spp": timed.spp},
            )
        recorder.measure(
            subject, "seconds", median_interval(timed.seconds), {**case, "spp": timed.spp}
        )
        recorder.measure(subject, "samples_per_second", throughput(samples, timed.seconds), case)
        for name, count in (timed.rays or {}).items():
            by_class = {**case, "rays": name}
            recorder.measure(subject, "rays_per_second", throughput(count, timed.seconds), by_class)
            recorder.measure(subject, "rays_per_sample", exact(count / samples, 1), by_class)
        for quantity, interval in _extras(timed).items():
            recorder.measure(subject, quantity, interval, case)


def _extras(timed: Timed) -> dict[str, Interval]:
    """Further numbers of the rows; raises SchemaError for one that is not a quantity."""
    extras: dict[str, list[float]] = defaultdict(list)
    for row in timed.rows:
        for name, value in row.items():
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if name == "seconds" or name in NOT_QUANTITIES or not is_number:
                continue
            if name not in load_list("quantities"):
                raise SchemaError(
                    f"timing.json of {timed.tracer}, {timed.model}: {name!r} is not in "
                    "harness/schemas/quantities.yaml"
                )
            extras[name].append(float(value))
    return {
        name: exact(values[0], 1)
        if name in ONCE or len(set(values)) == 1
        else median_interval(values)
        for name, values in extras.items()
        # A sweep repeats what its scene took to load.
        if not (timed.case and name in ONCE)
    }


def record_ratios(recorder: Recorder, job: SceneJob, times: list[Timed]) -> None:
    """Record how much faster each tracer is than those of RATIOS_TO, in samples a second."""
    timed = headline(times)
    for (model, tracer), own in timed.items():
        for other in RATIOS_TO:
            base = timed.get((model, other))
            if base is None or other == tracer:
                continue
            ratio = speed_ratio(own.seconds, own.spp, base.seconds, base.spp)
            subject = subject_of(job, model, tracer, own.engine)
            recorder.measure(subject, "speed_ratio", ratio, {"to": other})


def record_efficiency(
    recorder: Recorder, job: SceneJob, model: str, tracer: str, parts: tuple[ImageSet, Truth, Timed]
) -> None:
    """Record the time to unit variance and the efficiency of a tracer."""
    images, truth, timed = parts
    stack = images.images.astype(np.float64)
    if len(images.seeds) < 2 or not np.isfinite(stack).all():
        return
    subject = subject_of(job, model, tracer, timed.engine)
    for quantity, relative in (("ttuv_seconds", False), ("relative_ttuv_seconds", True)):
        split = split_error(stack, truth, relative=relative)
        ttuv = time_to_unit_variance(split.variance_by_image, images.spp, timed.seconds, timed.spp)
        interval = positive_interval(ttuv)
        recorder.measure(subject, quantity, interval)
        if relative and interval.value > 0.0 and not math.isnan(interval.lower):
            recorder.measure(subject, "efficiency", efficiency(interval))
