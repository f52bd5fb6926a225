"""Figures of the benchmark of rays: ratios by class, and tests a ray over the size of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullLocator

from harness.report.figures import guide, legend
from harness.report.rays import RayRow, shown_classes
from harness.report.style import FAINT, INK, colour_of, figure_style, make_panels, marker_of
from harness.statistics.intervals import Interval

COLUMNS = 4
TESTED = ("camera", "diffuse1", "random")
"""Classes whose tests a ray are shown."""

TRAVERSAL_STYLES = {
    "bvh2": ("#E69F00", "o"),
    "bvh2_stackless": ("#0072B2", "s"),
    "bvh8": ("#009E73", "D"),
    "brute_force": (FAINT, "x"),
}
"""Colour and marker of a traversal where all are of one tracer; Okabe and Ito's set."""

PAPER_CLAIM = (30_000, 16)
"""Triangles, and about how many tests the paper says that they take."""


def _fastest(rows: Sequence[RayRow], other: str, name: str) -> dict[tuple[str, str], Interval]:
    """By scene and tracer, the ratio of its fastest way that is not bought with accuracy."""
    best: dict[tuple[str, str], Interval] = {}
    for row in rows:
        if row.precision == "fast":
            continue
        ratio = row.ratios.get((other, name))
        key = (row.scene, row.tracer)
        if ratio is not None and (key not in best or ratio.value > best[key].value):
            best[key] = ratio
    return best


def _times(value: float, _: int) -> str:
    """Name a tick of a ratio; below 1 as a fraction, which is the shorter."""
    return f"{value:g}" if value >= 1 else f"1/{1 / value:g}"


def plot_ray_ratios(rows: Sequence[RayRow], other: str) -> Figure | None:
    """Rays a second of every tracer in its fastest way over those of `other`, a panel a class.

    The axis is logarithmic: twice as fast is as far from 1 as half as fast. None without a ratio.
    """
    found = {name: _fastest(rows, other, name) for name in shown_classes(rows)}
    found = {name: ratios for name, ratios in found.items() if ratios}
    if not found:
        return None
    scenes = list(dict.fromkeys(scene for ratios in found.values() for scene, _ in ratios))
    with figure_style():
        height = 1.1 + 0.32 * len(scenes)
        figure, all_axes = make_panels(-(-len(found) // COLUMNS), COLUMNS, height)
        for place, (axes, (name, ratios)) in enumerate(zip(all_axes, found.items(), strict=False)):
            for (scene, tracer), ratio in ratios.items():
                line, colour = scenes.index(scene), colour_of(tracer)
                if np.isfinite(ratio.lower):
                    axes.hlines(line, ratio.lower, ratio.upper, color=colour, lw=1.4)
                axes.plot(ratio.value, line, color=colour, marker=marker_of(tracer), ms=5.0)
            axes.axvline(1.0, color=INK, lw=0.8, zorder=0)
            axes.set_xscale("log", base=2)
            axes.xaxis.set_major_formatter(FuncFormatter(_times))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.set_ylim(len(scenes) - 0.5, -0.5)
            axes.set_yticks(range(len(scenes)), scenes if place % COLUMNS == 0 else [])
            axes.grid(visible=False, axis="y")
            axes.set_title(name.replace("_", " "))
            axes.set_xlabel(f"× {other}")
        for axes in all_axes[len(found) :]:
            axes.set_axis_off()
        legend(figure, {tracer for ratios in found.values() for _, tracer in ratios})
    return figure


def plot_ray_tests(rows: Sequence[RayRow], sizes: Mapping[str, int]) -> Figure | None:
    """Nodes and triangles that a traversal tests a ray, over the primitives of the scene.

    Both axes are logarithmic. sizes: primitives by scene. None where nothing was counted.
    """
    classes = [name for name in TESTED if any(name in row.nodes for row in rows)]
    if not classes:
        return None
    with figure_style():
        figure, all_axes = make_panels(1, max(3, len(classes)), 3.4)
        drawn: set[str] = set()
        for axes, name in zip(all_axes, classes, strict=False):
            for traversal, (colour, marker) in TRAVERSAL_STYLES.items():
                points = _tests(rows, sizes, traversal, name)
                if points:
                    drawn.add(traversal)
                    axes.plot(*zip(*points, strict=True), color=colour, marker=marker, mfc="white")
            _draw_guides(axes, sizes)
            axes.set_title(name)
            axes.set_xlabel("primitives of the scene")
        for axes in all_axes[len(classes) :]:
            axes.set_axis_off()
        all_axes[0].set_ylabel("nodes and triangles tested a ray")
        handles = [
            Line2D([], [], color=colour, marker=marker, mfc="white", label=traversal)
            for traversal, (colour, marker) in TRAVERSAL_STYLES.items()
            if traversal in drawn
        ]
        claim = Line2D([], [], color=INK, marker="*", ls="", ms=9, label="the paper's claim")
        legend(figure, [], [*handles, claim, guide("every primitive")])
    return figure


def _tests(
    rows: Sequence[RayRow], sizes: Mapping[str, int], traversal: str, name: str
) -> list[tuple[int, float]]:
    """Size and tests of each scene, rising; all tracers of the core count the same."""
    found = {
        sizes[row.scene]: row.nodes[name] + row.triangles[name]
        for row in rows
        if row.traversal == traversal
        and row.precision != "fast"
        and name in row.nodes
        and row.scene in sizes
    }
    return sorted(found.items())


def _draw_guides(axes: Axes, sizes: Mapping[str, int]) -> None:
    ends = np.array([min(sizes.values()), max(*sizes.values(), PAPER_CLAIM[0])], float)
    axes.plot(ends, ends, color=FAINT, ls="--", lw=1.0, zorder=0)
    axes.plot(*PAPER_CLAIM, color=INK, marker="*", ms=9)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
