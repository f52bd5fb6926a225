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
from harness.statistics.spectrum import (
    BANDS,
    ensemble,
    error_spectra,
    radial_frequencies,
    truth_spectrum,
)
from harness.tables.read import SceneJob
from harness.tables.trade import EXACT

COLUMNS = 4
LEAST = 4
"""Fewest runs that make an ensemble."""
TICKS = (0.02, 0.05, 0.1, 0.2, 0.5)


@dataclass(frozen=True, slots=True)
class Spectrum:
    """The spectra of one tracer's images of a scene in `path`."""

    scene: str
    tracer: str
    spp: int
    frequencies: NDArray[np.float64]
    """[M], cycles a pixel"""
    bands: NDArray[np.float64]
    """[len(BANDS), M], the runs at those shares"""
    mean: NDArray[np.float64]
    """[M], over the runs"""
    floor: float
    """what the truth's noise adds"""


def find_spectra(jobs: Sequence[SceneJob]) -> list[Spectrum]:
    """The spectra of every scene and tracer with enough independent, finite images."""
    found = []
    for job in jobs:
        tracers = job.tracers(EXACT) if EXACT in job.models else []
        truth = job.truth(EXACT) if tracers else None
        for tracer in tracers:
            images = job.seeds(EXACT, tracer)
            if images is None or truth is None or len(images.seeds) < LEAST:
                continue
            stack = images.images.astype(np.float64)
            if not np.isfinite(stack).all() or min(job.width, job.height) < 2:
                continue
            spectra = error_spectra(stack, truth)
            frequencies, _ = radial_frequencies(job.height, job.width)
            found.append(
                Spectrum(
                    job.name,
                    tracer,
                    images.spp,
                    frequencies,
                    ensemble(spectra),
                    spectra.mean(axis=0),
                    truth_spectrum(truth),
                )
            )
    return found


def spectrum_table(found: Sequence[Spectrum]) -> Table:
    """Power at the coarsest and the finest scale; the file has every frequency and band."""
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
            **{f"power_run_{share:g}": one.bands[row, place] for row, share in enumerate(BANDS)},
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
                    one.bands[BANDS.index(0.1)],
                    one.bands[BANDS.index(0.9)],
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
