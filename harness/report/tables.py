"""The tables of the report: each as rows of text for the page and as a data frame for its CSV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import pandas as pd

from harness.gate import Absent, Judgement
from harness.report import numbers
from harness.statistics.bias import Verdict
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.read import SceneJob, model_order, tracer_order
from harness.tables.times import RATIOS_TO, RAY_CLASSES

VERDICT_CLASS = {
    Verdict.PASS: "pass",
    Verdict.FAIL: "fail",
    Verdict.NOT_ENOUGH_SAMPLES: "wait",
}


@dataclass(frozen=True, slots=True)
class Cell:
    """Text of a table's cell, a fainter second text, and how it is drawn."""

    text: str
    faint: str = ""
    kind: str = "number"
    """number, text, prose (text that wraps), tracer, pass, fail or wait"""


@dataclass(frozen=True, slots=True)
class Column:
    """Heading of a column and the unit of its numbers."""

    title: str
    unit: str = ""
    kind: str = "number"


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the page. `frame` holds the same rows with full numbers, for the CSV."""

    name: str
    columns: Sequence[Column]
    groups: Sequence[tuple[str, Sequence[Sequence[Cell]]]]
    """rows under a heading that spans the table (empty for none)"""
    frame: pd.DataFrame = field(repr=False)


def _text(text: str) -> Cell:
    return Cell(text, kind="text")


def _tracer(name: str) -> Cell:
    return Cell(name, kind="tracer")


def number_cell(interval: Interval | None, factor: float = 1.0, digits: int = 3) -> Cell:
    """A value with its interval, both times a factor; a dash where there is none."""
    if interval is None:
        return Cell(numbers.MISSING)
    return Cell(
        numbers.significant(interval.value * factor, digits),
        numbers.bounds(interval, factor, digits),
    )


def columns_of(name: str, interval: Interval | None) -> dict[str, float | None]:
    """A value and its bounds as columns of a CSV."""
    if interval is None:
        return {name: None, f"{name}_lower": None, f"{name}_upper": None}
    return {
        name: interval.value,
        f"{name}_lower": interval.lower,
        f"{name}_upper": interval.upper,
    }


def find_knee(rates: dict[int, Interval], share: float = 0.98) -> int:
    """The smallest packet whose rate is within 2 % of the best."""
    best = max(interval.value for interval in rates.values())
    return min(size for size, interval in rates.items() if interval.value >= share * best)


def verdict_table(judgements: list[Judgement]) -> Table:
    """Scene, model, tracer: the verdict, and what the questions of the gate found."""
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for row in judgements:
        verdict = Cell(row.verdict.value, kind=VERDICT_CLASS[row.verdict])
        cells = [_text(row.model), _tracer(row.tracer), verdict]
        record: dict[str, object] = {
            "scene": row.scene,
            "model": row.model,
            "tracer": row.tracer,
            "verdict": row.verdict.value,
        }
        if row.bias is None or row.tiles is None:
            cells += [Cell(numbers.MISSING)] * 5
        else:
            interval, (p, *_) = row.bias.bias, row.tiles.smallest
            cells += [
                Cell(numbers.percent(interval.value, 3), numbers.percent_bounds(interval, 3)),
                Cell(f"±{100.0 * row.bias.delta:g}"),
                Cell(numbers.significant(p, 2)),
                Cell(str(row.rejected), f"of {row.tiles.p.size}"),
                Cell(numbers.significant(100.0 * row.tiles.detectable(row.tile_level), 2)),
            ]
            record |= {
                **columns_of("relative_bias", interval),
                "bound": row.bias.delta,
                "bias_verdict": row.bias.verdict.value,
                "seeds_needed": row.bias.seeds_needed,
                "tile_p_min": p,
                "tile_level": row.tile_level,
                "tiles_rejected": row.rejected,
                "tiles": row.tiles.p.size,
                "tile_verdict": row.tile_verdict.value,
            }
        defects = row.defects
        cells.append(
            Cell(numbers.MISSING if defects is None else str(defects.non_finite + defects.negative))
        )
        note = row.note
        if not note and row.bias is not None and row.bias.seeds_needed is not None:
            note = f"about {row.bias.seeds_needed} seeds needed"
        cells.append(_text(note))
        groups.setdefault(row.scene, []).append(cells)
        records.append({**record, "note": note})
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("verdict", kind="text"),
        Column("relative bias, 90 % interval", "%"),
        Column("bound", "%"),
        Column("smallest tile p"),
        Column("tiles rejected"),
        Column("visible tile error", "%"),
        Column("bad pixels"),
        Column("note", kind="text"),
    ]
    return Table("verdicts", columns, list(groups.items()), pd.DataFrame(records))


def absence_table(absent: list[Absent], jobs: list[SceneJob]) -> Table | None:
    """Tracers that were skipped, with the reason once; None if there are none."""
    if not absent:
        return None
    everywhere = {job.name for job in jobs}
    groups: dict[tuple[str, str], dict[str, list[str]]] = {}
    for row in absent:
        models = groups.setdefault((row.tracer, row.reason), {})
        models.setdefault(row.model, []).append(row.scene)
    rows = []
    for (tracer, reason), models in sorted(
        groups.items(), key=lambda item: tracer_order(item[0][0])
    ):
        scenes = list(dict.fromkeys(scene for found in models.values() for scene in found))
        named = "every scene" if everywhere <= set(scenes) else ", ".join(scenes)
        rows.append(
            [
                _tracer(tracer),
                _text(", ".join(sorted(models, key=model_order))),
                Cell(named, kind="prose"),
                _text(reason),
            ]
        )
    columns = [Column(title, kind="text") for title in ("tracer", "models", "scenes", "reason")]
    frame = pd.DataFrame(
        [(row.scene, row.model, row.tracer, row.reason) for row in absent],
        columns=["scene", "model", "tracer", "reason"],
    )
    return Table("skipped", columns, [("", rows)], frame)


def speed_table(measurements: Measurements, jobs: list[SceneJob]) -> Table:
    """Scene, model, tracer: samples and rays a second, ratios, time to unit variance."""
    groups, records = [], []
    for job in jobs:
        rows = []
        for model in job.models:
            for tracer in measurements.tracers("samples_per_second", job.name, model):
                where = {"scene": job.name, "model": model, "tracer": tracer}
                rate = measurements.find("samples_per_second", **where)
                rays = {
                    name: measurements.find("rays_per_second", case=f"rays={name}", **where)
                    for name in ("all", *RAY_CLASSES)
                }
                ratios = {
                    other: measurements.find("speed_ratio", case=f"to={other}", **where)
                    for other in RATIOS_TO
                }
                ttuv = measurements.find("relative_ttuv_seconds", **where)
                cells = [_text(model), _tracer(tracer), number_cell(rate, 1e-6)]
                for name, interval in rays.items():
                    value = None if interval is None else interval.value * 1e-6
                    faint = numbers.bounds(interval, 1e-6) if interval and name == "all" else ""
                    text = numbers.MISSING if not value else numbers.significant(value)
                    cells.append(Cell(text, faint))
                for other, ratio in ratios.items():
                    cells.append(Cell("1") if other == tracer else number_cell(ratio))
                cells.append(number_cell(ttuv and ttuv.scaled(1e3)))
                rows.append(cells)
                record: dict[str, object] = dict(where)
                record |= columns_of("samples_per_second", rate)
                for name, interval in rays.items():
                    record |= columns_of(f"rays_per_second_{name}", interval)
                for other, ratio in ratios.items():
                    record |= columns_of(f"ratio_to_{other.replace('-', '_')}", ratio)
                records.append(record | columns_of("relative_ttuv_seconds", ttuv))
        groups.append((job.name, rows))
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("samples", "M/s"),
        Column("all rays", "M/s"),
        *(Column(name, "M/s") for name in RAY_CLASSES),
        *(Column(f"× {name}") for name in RATIOS_TO),
        Column("time to unit variance", "ms"),
    ]
    return Table("speed", columns, groups, pd.DataFrame(records))


def times_table(measurements: Measurements, jobs: list[SceneJob]) -> Table:
    """Scene, model, tracer: every part of the time, and the size of the BVH."""
    parts = ("load", "build", "compile", "upload")
    groups, records = [], []
    for job in jobs:
        rows = []
        for model in job.models:
            for tracer in measurements.tracers("samples_per_second", job.name, model):
                where = {"scene": job.name, "model": model, "tracer": tracer}
                found = {part: measurements.find(f"{part}_seconds", **where) for part in parts}
                warm = measurements.sweep("seconds", "spp", **where)
                spp, image = next(iter(warm.items()), (0, None))
                bvh = measurements.find("bvh_bytes", **where)
                cells = [_text(model), _tracer(tracer)]
                cells += [
                    Cell(numbers.MISSING if value is None else numbers.seconds(value.value))
                    for value in (*found.values(), image)
                ]
                cells.append(Cell(str(spp) if spp else numbers.MISSING))
                cells.append(Cell(numbers.MISSING if bvh is None else numbers.size(bvh.value)))
                rows.append(cells)
                record: dict[str, object] = dict(where)
                record |= {
                    f"{part}_seconds": None if value is None else value.value
                    for part, value in found.items()
                }
                record |= columns_of("warm_image_seconds", image)
                records.append(record | {"spp": spp, "bvh_bytes": bvh.value if bvh else None})
        groups.append((job.name, rows))
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        *(Column(part) for part in parts),
        Column("image, warm"),
        Column("samples a pixel"),
        Column("BVH"),
    ]
    return Table("times", columns, groups, pd.DataFrame(records))


def error_table(measurements: Measurements, jobs: list[SceneJob]) -> Table:
    """Scene, model, tracer: error of one image, its variance, and the slope of convergence."""
    groups, records = [], []
    quantities = ("relmse", "smape", "relative_variance")
    for job in jobs:
        rows = []
        for model in job.models:
            for tracer in job.tracers(model):
                where = {"scene": job.name, "model": model, "tracer": tracer}
                cases = measurements.cases("relative_variance", **where)
                case = next((one for one in cases if one.startswith("seeds=")), "")
                found = {name: measurements.find(name, case=case, **where) for name in quantities}
                slope = measurements.find("slope", **where)
                spp = case.partition("spp=")[2]
                rows.append(
                    [
                        _text(model),
                        _tracer(tracer),
                        Cell(spp or numbers.MISSING),
                        *(number_cell(interval) for interval in found.values()),
                        Cell(numbers.MISSING) if slope is None else Cell(*numbers.fixed(slope, 3)),
                    ]
                )
                record: dict[str, object] = {**where, "spp": spp}
                for name, interval in {**found, "slope": slope}.items():
                    record |= columns_of(name, interval)
                records.append(record)
        groups.append((job.name, rows))
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("samples a pixel"),
        Column("relMSE"),
        Column("SMAPE"),
        Column("relative variance"),
        Column("slope"),
    ]
    return Table("errors", columns, groups, pd.DataFrame(records))


def packets_table(measurements: Measurements, jobs: list[SceneJob]) -> Table | None:
    """The knee of each sweep of packet sizes; None if nothing was swept."""
    groups, records = [], []
    for job in jobs:
        rows = []
        for model in job.models:
            for tracer in measurements.tracers("rays_per_second", job.name, model):
                for order in ("fifo", "lifo"):
                    where = {"scene": job.name, "model": model, "tracer": tracer}
                    sweep = {"engine": "packets", "order": order}
                    rates = measurements.sweep(
                        "rays_per_second", "packet", rays="all", **where, **sweep
                    )
                    if not rates:
                        continue
                    knee = find_knee(rates)
                    plain = measurements.find("rays_per_second", case="rays=all", **where)
                    share = rates[knee].value / plain.value if plain else float("nan")
                    queue = measurements.sweep("peak_queue_bytes", "packet", **where, **sweep)
                    size = queue.get(knee)
                    rows.append(
                        [
                            _text(model),
                            _tracer(tracer),
                            _text(order),
                            Cell(f"{knee:,}"),
                            number_cell(rates[knee], 1e-6),
                            Cell(numbers.significant(share)),
                            Cell(numbers.MISSING if size is None else numbers.size(size.value)),
                        ]
                    )
                    record: dict[str, object] = {**where, "order": order, "packet": knee}
                    record |= columns_of("rays_per_second", rates[knee])
                    record |= {
                        "share_of_depth_first": share,
                        "peak_queue_bytes": size.value if size else None,
                    }
                    records.append(record)
        groups.append((job.name, rows))
    if not records:
        return None
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("order", kind="text"),
        Column("knee", "rays a packet"),
        Column("all rays", "M/s"),
        Column("× depth_first"),
        Column("peak queue"),
    ]
    return Table("packets", columns, groups, pd.DataFrame(records))
