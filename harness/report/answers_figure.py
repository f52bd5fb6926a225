"""Figure of the error of every tracer on every scene whose radiance is known."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from harness.answers import DELTA, AnswerVerdict
from harness.report.figures import legend
from harness.report.forest import draw_estimate, finish_panel, spread
from harness.report.style import BAND, figure_style, make_panels
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
                place = places[row.scene] + spread(tracers.index(row.tracer), len(tracers), 0.6)
                draw_estimate(axes, place, row.error, row.tracer, limit)
            lines = [title for _, title in scenes] if axes is all_axes[0] else None
            finish_panel(axes, lines, len(scenes), limit, "error of the known radiance")
            axes.set_title(model)
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
