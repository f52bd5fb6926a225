"""Figure of the samples a second of every tracer on every scene."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from harness.report.scene_lines import Key, Look, plot_scene_lines
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements

LEAST = 1e-9
"""Lowest end of a line on an axis that has no zero."""


def _place_ticks(axes: Axes) -> None:
    axes.xaxis.set_major_locator(LogLocator(numticks=7))


LOOK = Look("million samples a second", 1.1, 0.27, 0.5, 1.4, _place_ticks)


def plot_speed(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    """Million samples a second with 95 % intervals, one panel a model, a line a scene.

    None where nothing of these scenes was timed.
    """
    found: dict[Key, Interval] = {}
    for row in measurements.rows:
        if row.quantity != "samples_per_second" or row.status != "ok" or row.case:
            continue
        if row.scene in scenes:
            rate = row.interval.scaled(1e-6)
            shown = Interval(rate.value, max(rate.lower, LEAST), rate.upper, rate.n)
            found[row.scene, row.model, row.tracer] = shown
    if not found:
        return None
    timed = {scene for scene, _, _ in found}
    return plot_scene_lines(found, [scene for scene in scenes if scene in timed], LOOK)
