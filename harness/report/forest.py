"""Forest plots (Lewis and Clarke 2001): estimates with intervals, a line a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from harness.report.style import FAINT, colour_of, marker_of
from harness.statistics.intervals import Interval


def spread(index: int, count: int, height: float) -> float:
    """Offset of one of `count` estimates on a line, which together take `height` of its pitch."""
    return height * (index / (count - 1) - 0.5) if count > 1 else 0.0


def draw_estimate(axes: Axes, place: float, estimate: Interval, tracer: str, limit: float) -> None:
    """Draw an estimate in per cent; one beyond `limit` stands at the edge, as a filled marker."""
    colour = colour_of(tracer)
    value = 100.0 * float(np.clip(estimate.value, -limit, limit))
    ends = 100.0 * np.clip([estimate.lower, estimate.upper], -limit, limit)
    axes.hlines(place, *ends, color=colour, lw=1.4)
    axes.plot(
        value,
        place,
        color=colour,
        marker=marker_of(tracer),
        ms=4.0,
        mfc="white" if abs(estimate.value) <= limit else colour,
    )


def finish_panel(
    axes: Axes, lines: Sequence[str] | None, count: int, limit: float, quantity: str
) -> None:
    """Set limits, labels and the line at zero; `lines` names the `count` lines, None hides them."""
    axes.axvline(0.0, color=FAINT, lw=0.8, zorder=1)
    axes.set_xlim(-105.0 * limit, 105.0 * limit)
    axes.set_ylim(count - 0.5, -0.5)
    axes.set_yticks(range(count), [] if lines is None else lines)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:+g}".replace("-", "−") if value else "0")
    )
    axes.set_xlabel(f"{quantity}, %")
