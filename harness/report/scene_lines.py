"""Figures of one quantity of every tracer on every scene: a panel a model, a line a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from harness.report.figures import legend
from harness.report.forest import spread
from harness.report.style import colour_of, figure_style, make_panels, marker_of
from harness.statistics.intervals import Interval
from harness.tables.read import model_order, tracer_order

Key = tuple[str, str, str]
"""Scene, model and tracer."""


@dataclass(frozen=True, slots=True)
class Look:
    """What such figures differ by."""

    label: str
    """of the quantity, with its unit"""
    margin: float
    """height of a figure without scenes, inches"""
    scene: float
    """height that a scene takes, inches"""
    reach: float
    """height over which the tracers of a scene are spread, in that of a scene"""
    stroke: float
    """width of the lines, points"""
    place_ticks: Callable[[Axes], None]
    """sets the ticks of a logarithmic axis whose limits are known"""


def plot_scene_lines(found: Mapping[Key, Interval], scenes: Sequence[str], look: Look) -> Figure:
    """A marker at each value, on a line from its lower to its upper bound."""
    models = sorted({model for _, model, _ in found}, key=model_order)
    tracers = sorted({tracer for _, _, tracer in found}, key=tracer_order)
    with figure_style():
        height = look.margin + look.scene * len(scenes)
        figure, all_axes = make_panels(1, max(2, len(models)), height)
        for axes, model in zip(all_axes, models, strict=False):
            for (scene, _, tracer), one in [own for own in found.items() if own[0][1] == model]:
                step = spread(tracers.index(tracer), len(tracers), look.reach)
                place, colour = scenes.index(scene) + step, colour_of(tracer)
                axes.hlines(place, one.lower, one.upper, color=colour, lw=look.stroke)
                axes.plot(
                    one.value, place, color=colour, marker=marker_of(tracer), ms=4.0, mfc="white"
                )
            axes.set_xscale("log")
            look.place_ticks(axes)
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.set_ylim(len(scenes) - 0.5, -0.5)
            axes.set_yticks(range(len(scenes)), scenes if axes is all_axes[0] else [])
            axes.tick_params(axis="y", length=0)
            axes.set_xlabel(look.label)
            axes.set_title(model)
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
