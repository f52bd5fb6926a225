"""Figure of the relative bias of every tracer on every scene."""

from __future__ import annotations

from matplotlib.figure import Figure

from harness.gate import Judgement
from harness.report.figures import legend
from harness.report.forest import draw_estimate, finish_panel, spread
from harness.report.style import BAND, figure_style, make_panels
from harness.tables.read import model_order, tracer_order


def plot_agreement(judgements: list[Judgement]) -> Figure | None:
    """Relative bias with its 90 % interval, one panel a model; None if nothing was compared.

    Bands show the bound of each scene. A bias beyond twice the widest bound is drawn at the edge,
    as a filled marker.
    """
    shown = [row for row in judgements if row.bias is not None]
    if not shown:
        return None
    models = sorted({row.model for row in shown}, key=model_order)
    scenes = list(dict.fromkeys(row.scene for row in shown))
    tracers = sorted({row.tracer for row in shown}, key=tracer_order)
    limit = 2.0 * max(row.bias.delta for row in shown if row.bias)
    with figure_style():
        figure, all_axes = make_panels(1, max(3, len(models)), 0.9 + 0.42 * len(scenes))
        for axes, model in zip(all_axes, models, strict=False):
            for row in [row for row in shown if row.model == model]:
                if row.bias is None:
                    continue
                place = float(scenes.index(row.scene))
                delta = 100.0 * row.bias.delta
                axes.fill_betweenx([place - 0.42, place + 0.42], -delta, delta, color=BAND, lw=0)
                place += spread(tracers.index(row.tracer), len(tracers), 0.5)
                draw_estimate(axes, place, row.bias.bias, row.tracer, limit)
            lines = scenes if axes is all_axes[0] else None
            finish_panel(axes, lines, len(scenes), limit, "relative bias of the image mean")
            axes.set_title(model)
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
