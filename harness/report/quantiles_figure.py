"""Figure of the spread of single images: the error that a user's one image may have."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from harness.report.figures import legend
from harness.report.forest import spread
from harness.report.style import colour_of, figure_style, make_panels, marker_of
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.read import model_order, tracer_order
from harness.tables.schema import parse_case

Key = tuple[str, str, str]
"""Scene, model and tracer."""


def find_quantiles(
    measurements: Measurements, wanted: Sequence[str]
) -> dict[Key, dict[float, Interval]]:
    """The relMSE of single images of those scenes at each quantile over the runs."""
    found: dict[Key, dict[float, Interval]] = {}
    for row in measurements.rows:
        if row.quantity != "relmse_quantile" or row.status != "ok" or row.scene not in wanted:
            continue
        if row.interval.value > 0.0:
            share = float(parse_case(row.case)["quantile"])
            found.setdefault((row.scene, row.model, row.tracer), {})[share] = row.interval
    return found


def plot_quantiles(measurements: Measurements, wanted: Sequence[str]) -> Figure | None:
    """RelMSE of nine images in ten, one panel a model, a line a scene; None without quantiles."""
    found = find_quantiles(measurements, wanted)
    if not found:
        return None
    scenes = list(dict.fromkeys(scene for scene, _, _ in found))
    models = sorted({model for _, model, _ in found}, key=model_order)
    tracers = sorted({tracer for _, _, tracer in found}, key=tracer_order)
    with figure_style():
        figure, all_axes = make_panels(1, max(2, len(models)), 1.0 + 0.42 * len(scenes))
        for axes, model in zip(all_axes, models, strict=False):
            for (scene, _, tracer), shares in [one for one in found.items() if one[0][1] == model]:
                place = scenes.index(scene) + spread(tracers.index(tracer), len(tracers), 0.62)
                colour = colour_of(tracer)
                axes.hlines(
                    place,
                    shares[min(shares)].value,
                    shares[max(shares)].value,
                    color=colour,
                    lw=1.6,
                )
                median = shares.get(0.5, Interval(math.nan, math.nan, math.nan, 0))
                axes.plot(
                    median.value, place, color=colour, marker=marker_of(tracer), ms=4.0, mfc="white"
                )
            axes.set_xscale("log")
            lowest, highest = axes.get_xlim()
            steps = (1.0, 2.0, 5.0) if highest < 100.0 * lowest else (1.0,)
            axes.xaxis.set_major_locator(LogLocator(subs=steps, numticks=6))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.set_ylim(len(scenes) - 0.5, -0.5)
            axes.set_yticks(range(len(scenes)), scenes if axes is all_axes[0] else [])
            axes.tick_params(axis="y", length=0)
            axes.grid(visible=False, axis="y")
            axes.set_xlabel("relMSE of one image (1)")
            axes.set_title(model)
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
