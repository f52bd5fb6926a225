"""Figure of the relative bias of every tracer on every scene."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from harness.gate import Judgement
from harness.report.figures import legend
from harness.report.style import BAND, FAINT, colour_of, figure_style, make_panels, marker_of
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
                place = scenes.index(row.scene)
                delta = 100.0 * row.bias.delta
                axes.fill_betweenx([place - 0.42, place + 0.42], -delta, delta, color=BAND, lw=0)
                offset = 0.0
                if len(tracers) > 1:
                    offset = 0.5 * (tracers.index(row.tracer) / (len(tracers) - 1) - 0.5)
                interval = row.bias.bias
                inside = abs(interval.value) <= limit
                value = 100.0 * float(np.clip(interval.value, -limit, limit))
                ends = 100.0 * np.clip([interval.lower, interval.upper], -limit, limit)
                axes.hlines(place + offset, *ends, color=colour_of(row.tracer), lw=1.6)
                axes.plot(
                    value,
                    place + offset,
                    color=colour_of(row.tracer),
                    marker=marker_of(row.tracer),
                    mfc="white" if inside else colour_of(row.tracer),
                )
            axes.axvline(0.0, color=FAINT, lw=0.8, zorder=1)
            axes.set_xlim(-105.0 * limit, 105.0 * limit)
            axes.set_ylim(len(scenes) - 0.5, -0.5)
            axes.set_yticks(range(len(scenes)), scenes)
            axes.tick_params(axis="y", length=0)
            axes.grid(visible=False, axis="y")
            axes.xaxis.set_major_formatter(
                FuncFormatter(lambda value, _: f"{value:+g}".replace("-", "−") if value else "0")
            )
            axes.set_title(model)
            axes.set_xlabel("relative bias of the image mean, %")
            if axes is not all_axes[0]:
                axes.set_yticklabels([])
        for axes in all_axes[len(models) :]:
            axes.set_axis_off()
        legend(figure, tracers)
    return figure
