"""Figure of the samples a second of every tracer on every scene."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from harness.report.figures import legend
from harness.report.forest import spread
from harness.report.style import colour_of, figure_style, make_panels, marker_of
from harness.tables.lookup import Measurements
from harness.tables.read import model_order, tracer_order


def plot_speed(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    """Million samples a second with 95 % intervals, one panel a model, a line a scene.

    None where nothing of these scenes was timed.
    """
    found = {
        (row.scene, row.model, row.tracer): row.interval.scaled(1e-6)
        for row in measurements.rows
        if row.quantity == "samples_per_second"
        and row.status == "ok"
        and not row.case
        and row.scene in scenes
    }
    if not found:
        return None
    shown = [scene for scene in scenes if any(key[0] == scene for key in found)]
    models = sorted({model for _, model, _ in found}, key=model_order)
    tracers = sorted({tracer for _, _, tracer in found}, key=tracer_order)
    with figure_style():
        figure, all_axes = make_panels(1, max(2, len(models)), 1.1 + 0.27 * len(shown))
        for axes, model in zip(all_axes, models, strict=False):
            for (scene, _, tracer), rate in [one for one in found.items() if one[0][1] == model]:
                place = shown.index(scene) + spread(tracers.index(tracer), len(tracers), 0.5)
                colour = colour_of(tracer)
                axes.hlines(place, max(rate.lower, 1e-9), rate.upper, color=colour, lw=1.4)
                axes.plot(
                    rate.value, place, color=colour, marker=marker_of(tracer), ms=4.0, mfc="white"
                )
            axes.set_xscale("log")
            axes.xaxis.set_major_locator(LogLocator(numticks=7))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.set_ylim(len(shown) - 0.5, -0.5)
            axes.set_yticks(range(len(shown)), shown if axes is all_axes[0] else [])
            axes.tick_params(axis="y", length=0)
            axes.set_xlabel("million samples a second")
            axes.set_title(model)
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
