"""Figure and table of the error spectrum ensemble: at which scale the error of an image lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import (
    FixedLocator,
    FuncFormatter,
    LogFormatterSciNotation,
    LogLocator,
    NullLocator,
)
from numpy.typing import NDArray

from harness.report import numbers
from harness.report.figures import guide, legend
from harness.report.style import FAINT, colour_of, figure_style, make_panels, marker_of
from harness.report.tables import Cell, Column, Table
from harness.tables.lookup import Measurement, Measurements
from harness.tables.schema import parse_case
from harness.tables.spectra import SHARES
from harness.tables.trade import EXACT

COLUMNS = 4
TICKS = (0.02, 0.05, 0.1, 0.2, 0.5)


@dataclass(frozen=True, slots=True)
class Spectrum:
    """The spectra of one tracer's images of a scene in `path`."""

    scene: str
    tracer: str
    spp: int
    frequencies: NDArray[np.float64]
    """[M], cycles a pixel"""
    runs: NDArray[np.float64]
    """[len(SHARES), M], the runs at those shares of all"""
    mean: NDArray[np.float64]
    """[M], over the runs"""
    floor: float
    """what the truth's noise adds"""


def find_spectra(measurements: Measurements, scenes: Sequence[str]) -> list[Spectrum]:
    """The spectra of every tracer's images of those scenes, in their order."""
    rows: dict[tuple[str, str], list[Measurement]] = {}
    for row in measurements.rows:
        if row.quantity in {"error_power", "error_power_run"} and row.scene in scenes:
            rows.setdefault((row.scene, row.tracer), []).append(row)
    found = [_spectrum_of(measurements, *key, own) for key, own in rows.items()]
    return sorted(found, key=lambda one: scenes.index(one.scene))


def _spectrum_of(
    measurements: Measurements, scene: str, tracer: str, rows: Sequence[Measurement]
) -> Spectrum:
    mean: dict[float, float] = {}
    runs: dict[float, list[float]] = {share: [] for share in SHARES}
    cases = [parse_case(row.case) for row in rows]
    for row, case in zip(rows, cases, strict=True):
        if row.quantity == "error_power":
            mean[float(case["frequency"])] = row.interval.value
        else:
            runs[float(case["quantile"])].append(row.interval.value)
    floor = measurements.find("truth_power", scene=scene, model=EXACT, tracer="truth")
    return Spectrum(
        scene,
        tracer,
        int(cases[0]["spp"]),
        np.array(list(mean)),
        np.array([runs[share] for share in SHARES]),
        np.array(list(mean.values())),
        floor.value if floor is not None else 0.0,
    )


def spectrum_table(found: Sequence[Spectrum]) -> Table:
    """Power at the coarsest and the finest scale; the file has every frequency."""
    groups: dict[str, list[list[Cell]]] = {}
    for one in found:
        coarse, fine = float(one.mean[0]), float(one.mean[-1])
        groups.setdefault(one.scene, []).append(
            [
                Cell(one.tracer, kind="tracer"),
                Cell(f"{one.spp:,}"),
                Cell(numbers.significant(coarse)),
                Cell(numbers.significant(fine)),
                Cell(numbers.significant(coarse / fine, 2) if fine > 0.0 else numbers.MISSING),
                Cell(numbers.significant(one.floor)),
            ]
        )
    columns = [
        Column("tracer", kind="text"),
        Column("samples a pixel"),
        Column("power at the coarsest scale", "1"),
        Column("power at 0.5 cycles a pixel", "1"),
        Column("coarsest over finest"),
        Column("the truth’s noise", "1"),
    ]
    frame = pd.DataFrame(
        {
            "scene": one.scene,
            "model": EXACT,
            "tracer": one.tracer,
            "spp": one.spp,
            "frequency_cycles_per_pixel": frequency,
            "power": one.mean[place],
            **{f"power_run_{share:g}": one.runs[row, place] for row, share in enumerate(SHARES)},
            "truth_noise": one.floor,
        }
        for one in found
        for place, frequency in enumerate(one.frequencies)
    )
    return Table("spectra", columns, list(groups.items()), frame)


def plot_spectra(found: Sequence[Spectrum]) -> Figure | None:
    """Power of the relative error over spatial frequency, a panel a scene; None without spectra."""
    scenes = list(dict.fromkeys(one.scene for one in found))
    if not scenes:
        return None
    with figure_style():
        rows = -(-len(scenes) // COLUMNS)
        figure, all_axes = make_panels(rows, COLUMNS, 2.15 if rows > 1 else 2.7)
        for axes, scene in zip(all_axes, scenes, strict=False):
            for one in [one for one in found if one.scene == scene]:
                colour = colour_of(one.tracer)
                axes.fill_between(
                    one.frequencies,
                    one.runs[0],
                    one.runs[-1],
                    color=colour,
                    alpha=0.15,
                    lw=0,
                )
                every = max(1, len(one.frequencies) // 5)
                axes.plot(
                    one.frequencies,
                    one.mean,
                    color=colour,
                    marker=marker_of(one.tracer),
                    mfc="white",
                    markevery=every,
                )
                if one.floor > 0.0:
                    axes.axhline(one.floor, color=FAINT, ls=":", lw=1.2, zorder=0)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.xaxis.set_major_locator(FixedLocator(TICKS))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            lowest, highest = axes.get_ylim()
            steps = (1.0, 2.0, 5.0) if highest < 50.0 * lowest else (1.0,)
            axes.yaxis.set_major_locator(LogLocator(subs=steps, numticks=6))
            axes.yaxis.set_major_formatter(LogFormatterSciNotation(labelOnlyBase=False))
            axes.yaxis.set_minor_locator(NullLocator())
            axes.set_title(scene)
        for place, axes in enumerate(all_axes):
            if place >= len(scenes):
                axes.set_axis_off()
                continue
            if place % COLUMNS == 0:
                axes.set_ylabel("power of the\nrelative error (1)")
            if place + COLUMNS >= len(scenes):
                axes.set_xlabel("frequency, cycles a pixel")
        legend(figure, {one.tracer for one in found}, [guide("noise of the truth", ":")])
    return figure
