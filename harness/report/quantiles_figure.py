"""Figure of the spread of single images: the error that a user's one image may have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from harness.report.scene_lines import Key, Look, plot_scene_lines
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.schema import parse_case


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


def _place_ticks(axes: Axes) -> None:
    lowest, highest = axes.get_xlim()
    steps = (1.0, 2.0, 5.0) if highest < 100.0 * lowest else (1.0,)
    axes.xaxis.set_major_locator(LogLocator(subs=steps, numticks=6))
    axes.grid(visible=False, axis="y")


LOOK = Look("relMSE of one image (1)", 1.0, 0.42, 0.62, 1.6, _place_ticks)


def _spread_of(shares: Mapping[float, Interval]) -> Interval:
    """The median image between the lowest and the highest quantile."""
    median = shares[0.5].value if 0.5 in shares else math.nan
    return Interval(median, shares[min(shares)].value, shares[max(shares)].value, len(shares))


def plot_quantiles(measurements: Measurements, wanted: Sequence[str]) -> Figure | None:
    """RelMSE of eight images in ten, one panel a model, a line a scene; None without quantiles."""
    found = find_quantiles(measurements, wanted)
    if not found:
        return None
    scenes = list(dict.fromkeys(scene for scene, _, _ in found))
    shown = {key: _spread_of(shares) for key, shares in found.items()}
    return plot_scene_lines(shown, scenes, LOOK)
