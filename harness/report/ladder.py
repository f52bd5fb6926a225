"""The ladder of engines: the same rays, scheduled in every way that a tracer has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from harness.report import numbers
from harness.report.figures import legend
from harness.report.style import colour_of, figure_style, make_panels, marker_of
from harness.report.tables import Cell, Column, Table
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.read import SceneJob
from harness.tables.schema import format_case, parse_case

LADDER = ("depth_first", "packets", "streams", "layers", "wavefront", "persistent")


@dataclass(frozen=True, slots=True)
class Rung:
    """One engine with one packet size on one scene in one model."""

    scene: str
    model: str
    tracer: str
    engine: str
    allocation: str
    packet: int | None
    rays_per_second: Interval
    samples_per_second: Interval | None
    peak_queue_bytes: float | None

    @property
    def label(self) -> str:
        """The engine, and where device memory is allocated if that was a choice."""
        return f"{self.engine}, {self.allocation}" if self.allocation else self.engine


def find_rungs(measurements: Measurements, jobs: Sequence[SceneJob]) -> list[Rung]:
    """All engines that were swept, in the ladder's order."""
    rungs = []
    for job in jobs:
        for model in job.models:
            for tracer in measurements.tracers("rays_per_second", job.name, model):
                where = {"scene": job.name, "model": model, "tracer": tracer}
                for engine in LADDER:
                    rungs += _rungs_of(measurements, where, engine)
    return rungs


def _rungs_of(measurements: Measurements, where: dict[str, str], engine: str) -> list[Rung]:
    rungs = []
    at = {**where, "engine": engine}
    for text in measurements.cases("rays_per_second", **at):
        case = parse_case(text)
        if case.pop("rays") != "all" or "accumulation" not in case:
            continue
        rate = measurements.find("rays_per_second", case=text, **at)
        own = format_case(case)
        queue = measurements.find("peak_queue_bytes", case=own, **at)
        if rate is None:
            continue
        rungs.append(
            Rung(
                **where,
                engine=engine,
                allocation=str(case.get("allocation", "")),
                packet=int(case["packet"]) if "packet" in case else None,
                rays_per_second=rate,
                samples_per_second=measurements.find("samples_per_second", case=own, **at),
                peak_queue_bytes=queue.value if queue else None,
            )
        )
    return sorted(rungs, key=lambda rung: (rung.allocation != "per_packet", rung.packet or 0))


def ladder_table(rungs: Sequence[Rung]) -> Table | None:
    """Rates of every engine beside those of the same tracer's `depth_first`; None without any."""
    if not rungs:
        return None
    plain = {
        (rung.scene, rung.model, rung.tracer): rung.rays_per_second.value
        for rung in rungs
        if rung.engine == "depth_first"
    }
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for rung in rungs:
        own = plain.get((rung.scene, rung.model, rung.tracer))
        share = rung.rays_per_second.value / own if own else float("nan")
        rates = [rung.samples_per_second, rung.rays_per_second]
        groups.setdefault(rung.scene, []).append(
            [
                Cell(rung.model, kind="text"),
                Cell(rung.tracer, kind="tracer"),
                Cell(rung.label, kind="text"),
                Cell(f"{rung.packet:,}" if rung.packet else numbers.MISSING),
                *(Cell(*_mega(rate)) for rate in rates),
                Cell(numbers.significant(share)),
                Cell(numbers.size(rung.peak_queue_bytes) if rung.packet else numbers.MISSING),
            ]
        )
        records.append(
            {
                "scene": rung.scene,
                "model": rung.model,
                "tracer": rung.tracer,
                "engine": rung.engine,
                "allocation": rung.allocation,
                "packet": rung.packet,
                "rays_per_second": rung.rays_per_second.value,
                "rays_per_second_lower": rung.rays_per_second.lower,
                "rays_per_second_upper": rung.rays_per_second.upper,
                "share_of_depth_first": share,
                "peak_queue_bytes": rung.peak_queue_bytes,
            }
        )
    columns = [
        Column("model", kind="text"),
        Column("tracer", kind="text"),
        Column("engine", kind="text"),
        Column("packet", "rays"),
        Column("samples", "M/s"),
        Column("all rays", "M/s"),
        Column("× depth_first"),
        Column("peak queue"),
    ]
    return Table("engines", columns, list(groups.items()), pd.DataFrame(records))


def _mega(rate: Interval | None) -> tuple[str, str]:
    if rate is None:
        return numbers.MISSING, ""
    return numbers.significant(rate.value * 1e-6), numbers.bounds(rate, 1e-6)


def plot_ladder(rungs: Sequence[Rung]) -> Figure | None:
    """Rays a second of every engine, at its best packet size, one panel a scene and model.

    The axis is logarithmic: the ladder spans three decades on a GPU. None without rungs.
    """
    if not rungs:
        return None
    panels = list(dict.fromkeys((rung.scene, rung.model) for rung in rungs))
    labels = sorted({rung.label for rung in rungs}, key=_place)
    with figure_style():
        height = 1.0 + 0.3 * len(labels)
        figure, all_axes = make_panels(-(-len(panels) // 3), 3, height)
        for axes, panel in zip(all_axes, panels, strict=False):
            best: dict[tuple[str, str], Rung] = {}
            for rung in rungs:
                key = (rung.tracer, rung.label)
                known = best.get(key)
                faster = known is None or rung.rays_per_second.value > known.rays_per_second.value
                if (rung.scene, rung.model) == panel and faster:
                    best[key] = rung
            for (tracer, label), rung in best.items():
                row = labels.index(label)
                rate = rung.rays_per_second.scaled(1e-6)
                axes.hlines(row, max(rate.lower, 0.0), rate.upper, color=colour_of(tracer), lw=1.4)
                axes.plot(
                    rate.value, row, color=colour_of(tracer), marker=marker_of(tracer), ms=5.0
                )
            axes.set_xscale("log")
            lowest, highest = axes.get_xlim()
            steps = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0) if highest < 10.0 * lowest else (1.0,)
            axes.xaxis.set_major_locator(LogLocator(subs=steps))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.set_ylim(len(labels) - 0.5, -0.5)
            axes.set_yticks(range(len(labels)), labels)
            axes.grid(visible=False, axis="y")
            axes.set_title(f"{panel[0]}, {panel[1]}")
            axes.set_xlabel("million rays a second")
        for axes in all_axes[len(panels) :]:
            axes.set_axis_off()
        legend(figure, {rung.tracer for rung in rungs})
    return figure


def _place(label: str) -> tuple[int, str]:
    engine, _, allocation = label.partition(", ")
    # per_packet before once: the paper's own comes first.
    return LADDER.index(engine), "" if allocation == "per_packet" else allocation
