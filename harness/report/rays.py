"""The benchmark of rays in the report: its rows, and their tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd

from harness.rays.classes import CLASSES
from harness.report import numbers
from harness.report.tables import Cell, Column, Table
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurement, Measurements
from harness.tables.rays import ENGINE, MODEL, RATIOS_TO, RayJob
from harness.tables.read import tracer_order
from harness.tables.schema import parse_case

WITHOUT_RT_CORES = ("V100", "A30", "A100", "H100", "H200", "H800")
"""GPUs on which OptiX traverses in software, as they are called in the names of devices."""

SHOWN_VISITS = ("camera", "diffuse1")
"""Classes whose visits the table of hierarchies shows; the CSV has all."""


@dataclass(slots=True)
class RayRow:
    """One tracer in one way on one scene; the mappings are by class of rays."""

    scene: str
    tracer: str
    traversal: str
    precision: str
    rates: dict[str, Interval] = field(default_factory=dict)
    ratios: dict[tuple[str, str], Interval] = field(default_factory=dict)
    """by the tracer that is compared with, and class"""
    nodes: dict[str, float] = field(default_factory=dict)
    triangles: dict[str, float] = field(default_factory=dict)
    wrong: dict[str, float] = field(default_factory=dict)
    """rays per million that differ from double precision"""
    differing: dict[str, float] = field(default_factory=dict)
    """the same from another tracer, at most"""
    joules: dict[str, float] = field(default_factory=dict)
    once: dict[str, float] = field(default_factory=dict)
    """what is the same for every class, by quantity"""
    reasons: dict[str, str] = field(default_factory=dict)
    """status and reason of what there is no rate of"""

    @property
    def way(self) -> str:
        """How it traces; the arithmetic is named where it is not the tracer's own."""
        return f"{self.traversal}, fast" if self.precision == "fast" else self.traversal


def find_ray_rows(measurements: Measurements) -> list[RayRow]:
    """Collect what was measured, scenes in the order of the file, tracers in the registry's."""
    found: dict[tuple[str, str, str, str], RayRow] = {}
    for row in measurements.rows:
        if row.engine != ENGINE or row.model != MODEL or row.quantity.startswith("eye_rays"):
            continue
        case = parse_case(row.case)
        if "aim" in case:
            continue
        key = (row.scene, row.tracer, str(case.get("traversal", "")), row.precision)
        _add(found.setdefault(key, RayRow(*key)), row, case)
    scenes = list(dict.fromkeys(row.scene for row in found.values()))
    return sorted(
        found.values(), key=lambda row: (scenes.index(row.scene), tracer_order(row.tracer))
    )


def _add(own: RayRow, row: Measurement, case: Mapping[str, object]) -> None:
    rays, other, value = str(case.get("rays", "")), str(case.get("to", "")), row.interval.value
    if row.quantity == "rays_per_second":
        if row.status == "ok":
            own.rates[rays] = row.interval
        else:
            own.reasons[rays] = row.note
    elif row.quantity == "speed_ratio":
        own.ratios[other, rays] = row.interval
    elif row.quantity == "disagreement_ppm" and other:
        own.differing[rays] = max(own.differing.get(rays, 0.0), value)
    elif row.status == "ok":
        by_class = {
            "nodes_per_ray": own.nodes,
            "triangles_per_ray": own.triangles,
            "disagreement_ppm": own.wrong,
            "joules": own.joules,
        }
        place = by_class.get(row.quantity)
        if place is not None:
            place[rays] = value
        elif not rays:
            own.once[row.quantity] = value


def optix_note(jobs: Iterable[RayJob]) -> str:
    """What OptiX is on the GPU of a run, for every caption; empty without a GPU."""
    gpus = [gpu for job in jobs for gpu in job.gpus]
    if not gpus:
        return ""
    software = all(any(name in gpu for name in WITHOUT_RT_CORES) for gpu in gpus)
    return "mitsuba-cuda: OptiX through Mitsuba" + (
        ", no RT cores on this GPU." if software else "."
    )


def shown_classes(rows: Sequence[RayRow]) -> list[str]:
    """Classes of which anything was measured, in their own order."""
    return [name for name in CLASSES if any(name in row.rates for row in rows)]


def _names(row: RayRow) -> list[Cell]:
    return [Cell(row.tracer, kind="tracer"), Cell(row.way, kind="text")]


def _by_scene(
    rows: Sequence[RayRow], cells: Callable[[RayRow], list[Cell]]
) -> list[tuple[str, list[list[Cell]]]]:
    groups: dict[str, list[list[Cell]]] = {}
    for row in rows:
        groups.setdefault(row.scene, []).append([*_names(row), *cells(row)])
    return list(groups.items())


def _record(row: RayRow) -> dict[str, object]:
    return {
        "scene": row.scene,
        "tracer": row.tracer,
        "traversal": row.traversal,
        "precision": row.precision,
    }


def ray_table(rows: Sequence[RayRow]) -> Table | None:
    """Rays a second by class; None where nothing was timed."""
    timed, classes = [row for row in rows if row.rates], shown_classes(rows)
    if not timed:
        return None

    def cells(row: RayRow) -> list[Cell]:
        found = [row.rates.get(name) for name in classes]
        return [
            Cell(numbers.significant(rate.value * 1e-6), numbers.bounds(rate, 1e-6))
            if rate
            else Cell(numbers.MISSING)
            for rate in found
        ]

    records = []
    for row in timed:
        record = _record(row)
        for name, rate in row.rates.items():
            record |= {name: rate.value, f"{name}_lower": rate.lower, f"{name}_upper": rate.upper}
        records.append(record)
    columns = [
        *(Column(title, kind="text") for title in ("tracer", "traversal")),
        *(Column(name.replace("_", " "), "M/s") for name in classes),
    ]
    return Table("rays", columns, _by_scene(timed, cells), pd.DataFrame(records))


def geometric_mean(values: Iterable[float]) -> float:
    """Geometric mean of positive numbers; NaN of none."""
    logs = [math.log(value) for value in values]
    return math.exp(sum(logs) / len(logs)) if logs else math.nan


def ratio_table(rows: Sequence[RayRow]) -> Table | None:
    """Rays a second over another tracer's: geometric means over scenes; None without any."""
    classes = shown_classes(rows)
    ways = list(dict.fromkeys((row.tracer, row.way) for row in rows))
    groups, records = [], []
    for other in RATIOS_TO:
        body = []
        for tracer, way in ways:
            own = [row for row in rows if (row.tracer, row.way) == (tracer, way)]
            ratios = {
                name: [row.ratios[other, name].value for row in own if (other, name) in row.ratios]
                for name in classes
            }
            if not any(ratios.values()):
                continue
            means = {name: geometric_mean(values) for name, values in ratios.items()}
            scenes = max(len(values) for values in ratios.values())
            found = [Cell(numbers.significant(mean)) for mean in means.values()]
            body.append([*_names(own[0]), *found, Cell(str(scenes))])
            records.append({"to": other, "tracer": tracer, "way": way, "scenes": scenes, **means})
        if body:
            groups.append((f"over {other}", body))
    if not groups:
        return None
    columns = [
        *(Column(title, kind="text") for title in ("tracer", "traversal")),
        *(Column(name.replace("_", " "), "×") for name in classes),
        Column("scenes"),
    ]
    return Table("ray_ratios", columns, groups, pd.DataFrame(records))


def hierarchy_table(rows: Sequence[RayRow]) -> Table | None:
    """Builds, sizes, visits, energy and disagreement; None without rows."""
    known = [row for row in rows if row.once or row.wrong]
    if not known:
        return None

    def number(value: float | None, factor: float = 1.0) -> Cell:
        missing = value is None or math.isnan(value)
        return Cell(numbers.MISSING if missing else numbers.significant(value * factor))

    def cells(row: RayRow) -> list[Cell]:
        build, peak = row.once.get("build_seconds"), row.once.get("peak_bytes")
        return [
            Cell(numbers.MISSING if build is None else numbers.seconds(build)),
            number(row.once.get("bytes_per_triangle")),
            Cell(numbers.MISSING if peak is None else numbers.size(peak)),
            *(number(row.nodes.get(name)) for name in SHOWN_VISITS),
            *(number(row.triangles.get(name)) for name in SHOWN_VISITS),
            number(next(iter(row.joules.values()), None)),
            number(max(row.wrong.values(), default=math.nan)),
            number(max(row.differing.values(), default=math.nan)),
        ]

    records = []
    for row in known:
        record = {**_record(row), **row.once}
        for what in ("nodes", "triangles", "joules", "wrong", "differing"):
            record |= {f"{what}_{name}": value for name, value in getattr(row, what).items()}
        records.append(record)
    columns = [
        *(Column(title, kind="text") for title in ("tracer", "traversal")),
        Column("build"),
        Column("a triangle", "B"),
        Column("peak memory"),
        *(Column(f"nodes a ray, {name}") for name in SHOWN_VISITS),
        *(Column(f"triangles a ray, {name}") for name in SHOWN_VISITS),
        Column("energy", "J"),
        Column("differ from double precision, at most", "ppm"),
        Column("differ from a tracer, at most", "ppm"),
    ]
    return Table("ray_hierarchies", columns, _by_scene(known, cells), pd.DataFrame(records))


def missing_table(rows: Sequence[RayRow]) -> Table | None:
    """Who was not timed, in which way, on which scenes, and why; None where all were."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    everywhere = {row.scene for row in rows}
    for row in rows:
        for reason in dict.fromkeys(row.reasons.values()):
            groups.setdefault((row.tracer, row.way, reason), []).append(row.scene)
    if not groups:
        return None
    body = [
        [
            *(Cell(tracer, kind="tracer"), Cell(way, kind="text")),
            Cell("every scene" if everywhere <= set(scenes) else ", ".join(scenes), kind="prose"),
            Cell(reason, kind="text"),
        ]
        for (tracer, way, reason), scenes in groups.items()
    ]
    titles = ("tracer", "traversal", "scenes", "reason")
    frame = pd.DataFrame(
        [(*key[:2], " ".join(scenes), key[2]) for key, scenes in groups.items()], columns=titles
    )
    return Table(
        "rays_skipped", [Column(title, kind="text") for title in titles], [("", body)], frame
    )
