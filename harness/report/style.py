"""One look for all figures: colours, markers, type and a deterministic SVG."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from harness.tracers.registry import COLOURS
from harness.whole_files import write_whole

MARKERS = {
    "haste-cuda": "D",
    "haste-cpu": "o",
    "embree": "s",
    "mitsuba-llvm": "^",
    "mitsuba-cuda": "v",
    "mitsuba-scalar": "P",
    "truth": "x",
}
"""A second sign beside the colour, since equal curves lie on top of each other."""

INK = "#1b1f24"
FAINT = "#8b949e"
GRID = "#e6e8eb"
BAND = "#eef1f4"
WIDTH = 10.4
"""Width of a figure in inches; at 96 pixels an inch the width of the page's text."""

SETTINGS = {
    "svg.hashsalt": "haste",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.sans-serif": ["Inter", "Helvetica Neue", "Arial", "DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.5,
    "lines.markersize": 4.5,
    "figure.facecolor": "white",
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.h_pad": 0.08,
    "figure.constrained_layout.w_pad": 0.08,
}


def colour_of(tracer: str) -> str:
    """Colour of a tracer in every figure and table; grey for one that is not registered."""
    return COLOURS.get(tracer, FAINT)


def marker_of(tracer: str) -> str:
    """Marker of a tracer in every figure."""
    return MARKERS.get(tracer, ".")


@contextmanager
def figure_style() -> Iterator[None]:
    """Apply the figure settings, and put the old ones back."""
    with mpl.rc_context(SETTINGS):
        yield


def make_panels(rows: int, columns: int, panel_height: float) -> tuple[Figure, list[Axes]]:
    """An empty figure of the page's width with rows * columns panels, in reading order."""
    figure = Figure(figsize=(WIDTH, rows * panel_height))
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, list(axes.ravel())


def _lay_out(figure: Figure) -> None:
    """Place a figure's parts for good, as saving it would, which draws everything twice for that.

    The layout is in points, as of an SVG; the figure gets no other afterwards.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    canvas = FigureCanvasSVG(figure)
    dpi, figure.dpi = figure.dpi, canvas.fixed_dpi
    engine.execute(figure)
    figure.dpi = dpi
    with mpl.rc_context({"figure.constrained_layout.use": False}):
        figure.set_layout_engine(None)


def save_svg(figure: Figure, path: Path) -> None:
    """Write a figure as SVG: the same bytes for the same figure, without a date."""
    drawing = io.StringIO()
    with figure_style():
        _lay_out(figure)
        figure.savefig(drawing, format="svg", metadata={"Date": None, "Creator": "Haste"})
    # Matplotlib leaves blanks at the ends of lines.
    lines = (line.rstrip() for line in drawing.getvalue().splitlines())
    write_whole(path, "\n".join(lines) + "\n")
