"""Figure of the error of every tracer on every scene whose radiance is known."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from harness.answers import DELTA, AnswerVerdict
from harness.report.figures import legend
from harness.report.style import BAND, FAINT, colour_of, figure_style, make_panels, marker_of
from harness.tables.read import model_order, tracer_order


def plot_answers(verdicts: list[AnswerVerdict]) -> Figure | None:
    """Relative error with its 99 % interval, one panel a model; None if nothing was judged.

    An error beyond twice the bound is drawn at the edge, as a filled marker.
    """
    shown = [row for row in verdicts if math.isfinite(row.error.value)]
    if not shown:
        return None
    models = sorted({row.model for row in shown}, key=model_order)
    scenes = list(dict.fromkeys((row.scene, row.title) for row in shown))
    places = {scene: place for place, (scene, _) in enumerate(scenes)}
    tracers = sorted({row.tracer for row in shown}, key=tracer_order)
    limit = 2.0 * DELTA
    with figure_style():
        figure, all_axes = make_panels(1, max(3, len(models)), 0.9 + 0.36 * len(scenes))
        for axes, model in zip(all_axes, models, strict=False):
            axes.axvspan(-100.0 * DELTA, 100.0 * DELTA, color=BAND, lw=0, zorder=0)
            for row in [row for row in shown if row.model == model]:
                place = places[row.scene]
                if len(tracers) > 1:
                    place += 0.6 * (tracers.index(row.tracer) / (len(tracers) - 1) - 0.5)
                inside = abs(row.error.value) <= limit
                value = 100.0 * float(np.clip(row.error.value, -limit, limit))
                ends = 100.0 * np.clip([row.error.lower, row.error.upper], -limit, limit)
                colour = colour_of(row.tracer)
                axes.hlines(place, *ends, color=colour, lw=1.4)
                axes.plot(
                    value,
                    place,
                    color=colour,
                    marker=marker_of(row.tracer),
                    ms=4.0,
                    mfc="white" if inside else colour,
                )
            axes.axvline(0.0, color=FAINT, lw=0.8, zorder=1)
            axes.set_xlim(-105.0 * limit, 105.0 * limit)
            axes.set_ylim(len(scenes) - 0.5, -0.5)
            axes.set_yticks(range(len(scenes)), [title for _, title in scenes])
            axes.tick_params(axis="y", length=0)
            axes.grid(visible=False, axis="y")
            axes.xaxis.set_major_formatter(
                FuncFormatter(lambda value, _: f"{value:+g}".replace("-", "−") if value else "0")
            )
            axes.set_title(model)
            axes.set_xlabel("error of the known radiance, %")
            if axes is not all_axes[0]:
                axes.set_yticklabels([])
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
