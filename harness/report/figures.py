"""Figures of convergence, packet sizes and the plane of time and error."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

from harness.report.style import FAINT, INK, colour_of, figure_style, make_panels, marker_of
from harness.report.tables import find_knee
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.read import tracer_order

Panel = tuple[str, str]
"""Scene and model."""
COLUMNS = 3
MOST_PANELS = 6
"""Panels of one figure: two rows, which a page of paper has room for."""


def legend(figure: Figure, tracers: Iterable[str], extra: list[Line2D] | None = None) -> None:
    """One legend above all panels: the tracers in the registry's order, then guides."""
    handles = [
        Line2D([], [], color=colour_of(name), marker=marker_of(name), mfc="white", label=name)
        for name in sorted(set(tracers), key=tracer_order)
    ]
    handles += extra or []
    figure.legend(handles=handles, loc="outside upper left", ncols=len(handles), borderaxespad=0.2)


def guide(label: str, style: str = "--") -> Line2D:
    """Legend entry of a guide line."""
    return Line2D([], [], color=FAINT, linestyle=style, linewidth=1.0, label=label)


def _error_bars(
    axes: Axes, x: list[float], found: list[Interval], tracer: str, **style: str
) -> None:
    value = np.array([interval.value for interval in found])
    lower = np.array([interval.lower for interval in found])
    upper = np.array([interval.upper for interval in found])
    # An interval that reaches below zero ends at a tenth of the value on a logarithmic axis.
    lower = np.where(lower > 0.0, lower, 0.1 * value)
    known = np.isfinite(upper)
    axes.vlines(
        np.array(x)[known], lower[known], upper[known], color=colour_of(tracer), lw=1.0, alpha=0.6
    )
    axes.plot(x, value, color=colour_of(tracer), marker=marker_of(tracer), mfc="white", **style)


def powers_of_two(axes: Axes, values: Iterable[int], every: int = 1) -> None:
    """Make the horizontal axis logarithmic, with ticks at every so many of the values."""
    ticks = sorted(set(values))[::every]
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))


def _positive(found: dict[int, Interval]) -> dict[int, Interval]:
    return {key: interval for key, interval in found.items() if interval.value > 0.0}


def _converging(measurements: Measurements, scene: str, model: str) -> list[str]:
    """Tracers with images at several sample counts."""
    return [
        tracer
        for tracer in measurements.tracers("image_seconds", scene, model)
        if measurements.sweep("image_seconds", "spp", scene=scene, model=model, tracer=tracer)
    ]


def converging_panels(measurements: Measurements, panels: Iterable[Panel]) -> list[Panel]:
    """Those of which there are images at several sample counts."""
    return [panel for panel in panels if _converging(measurements, *panel)]


def _grid(panels: Sequence[Panel]) -> tuple[Figure, list[Axes]]:
    """Panels in reading order, at least COLUMNS a row, with their names."""
    figure, all_axes = make_panels(-(-len(panels) // COLUMNS), COLUMNS, 2.75)
    for axes, panel in zip(all_axes, panels, strict=False):
        axes.set_title(", ".join(panel))
        axes.set_yscale("log")
        axes.yaxis.set_minor_locator(NullLocator())
    for axes in all_axes[len(panels) :]:
        axes.set_axis_off()
    for axes in all_axes[::COLUMNS]:
        axes.set_ylabel("relMSE (1)")
    return figure, all_axes


def plot_convergence(measurements: Measurements, panels: Sequence[Panel]) -> Figure | None:
    """Error against samples a pixel, one panel a scene and model; None without panels."""
    if not panels:
        return None
    with figure_style():
        figure, all_axes = _grid(panels)
        seen: set[str] = set()
        for axes, (scene, model) in zip(all_axes, panels, strict=False):
            counts: set[int] = set()
            top = 0.0
            slopes = []
            for tracer in _converging(measurements, scene, model):
                where = {"scene": scene, "model": model, "tracer": tracer}
                found = _positive(measurements.sweep("relmse", "spp", **where))
                if not found:
                    continue
                _error_bars(axes, [float(n) for n in found], list(found.values()), tracer)
                seen.add(tracer)
                counts |= set(found)
                top = max(top, found[min(found)].value)
                slopes.append((tracer, measurements.find("slope", **where)))
            if not counts:
                axes.set_axis_off()
                continue
            ends = np.array([min(counts), max(counts)], dtype=float)
            axes.plot(ends, 1.6 * top * ends[0] / ends, color=FAINT, ls="--", lw=1.0, zorder=0)
            noise = measurements.find("truth_noise", scene=scene, model=model, tracer="truth")
            if noise is not None and noise.value > 0.0:
                axes.axhline(noise.value, color=FAINT, ls=":", lw=1.2, zorder=0)
            powers_of_two(axes, counts)
            _write_slopes(axes, slopes)
            axes.set_xlabel("samples a pixel")
        legend(figure, seen, [guide("slope −1"), guide("noise of the truth", ":")])
    return figure


def _write_slopes(axes: Axes, slopes: list[tuple[str, Interval | None]]) -> None:
    # Errors fall from the upper left to the lower right: below the curves there is always room.
    for row, (tracer, slope) in enumerate(reversed(slopes)):
        if slope is None:
            continue
        text = f"{slope.value:.3f}"
        if np.isfinite(slope.lower):
            text += f" [{slope.lower:.2f}, {slope.upper:.2f}]"
        axes.annotate(
            text.replace("-", "−"),
            (0.03, 0.1),
            xytext=(0, 11 * row),
            ha="left",
            va="bottom",
            xycoords="axes fraction",
            textcoords="offset points",
            color=colour_of(tracer),
            fontsize=7.5,
        )


def plot_plane(measurements: Measurements, panels: Sequence[Panel]) -> Figure | None:
    """Time of an image against its relMSE, one panel a scene and model; None without panels."""
    if not panels:
        return None
    with figure_style():
        figure, all_axes = _grid(panels)
        seen: set[str] = set()
        for axes, (scene, model) in zip(all_axes, panels, strict=False):
            corners = []
            for tracer in _converging(measurements, scene, model):
                where = {"scene": scene, "model": model, "tracer": tracer}
                errors = _positive(measurements.sweep("relmse", "spp", **where))
                times = measurements.sweep("image_seconds", "spp", **where)
                both = [spp for spp in errors if spp in times]
                if not both:
                    continue
                x = [times[spp].value for spp in both]
                _error_bars(axes, x, [errors[spp] for spp in both], tracer)
                seen.add(tracer)
                corners += [(t, errors[spp].value) for t, spp in zip(x, both, strict=True)]
            if not corners:
                axes.set_axis_off()
                continue
            axes.set_xscale("log")
            axes.xaxis.set_minor_locator(NullLocator())
            x_values = [x for x, _ in corners]
            narrow = max(x_values) < 1e3 * min(x_values)
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0) if narrow else (1.0,)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.margins(0.08)
            _equal_efficiency(axes, np.array(corners))
            axes.set_xlabel("seconds an image")
        legend(figure, seen, [guide("equal efficiency")])
    return figure


def _equal_efficiency(axes: Axes, points: np.ndarray) -> None:
    """Draw lines time * error = constant, one a decade, without moving the axes."""
    axes.autoscale_view()
    x_limits, y_limits = axes.get_xlim(), axes.get_ylim()
    products = np.log10(points[:, 0] * points[:, 1])
    ends = np.array(x_limits)
    for exponent in range(int(np.floor(products.min())), int(np.ceil(products.max())) + 1):
        axes.plot(ends, 10.0**exponent / ends, color=FAINT, ls="--", lw=0.6, alpha=0.7, zorder=0)
    axes.set_xlim(x_limits)
    axes.set_ylim(y_limits)


def plot_packets(measurements: Measurements, panels: list[Panel]) -> Figure | None:
    """Rays a second against the packet size, first in first out and last in first out.

    One panel for each scene and model that was swept; None if there is none.
    """
    swept = [
        (panel, tracer)
        for panel in panels
        for tracer in measurements.tracers("rays_per_second", *panel)
        if _packets(measurements, panel, tracer, "fifo")
        or _packets(measurements, panel, tracer, "lifo")
    ]
    if not swept:
        return None
    shown = list(dict.fromkeys(panel for panel, _ in swept))
    with figure_style():
        figure, all_axes = make_panels(-(-len(shown) // 3), 3, 2.9)
        for axes, panel in zip(all_axes, shown, strict=False):
            sizes: set[int] = set()
            rates: list[float] = []
            for tracer in [tracer for other, tracer in swept if other == panel]:
                for order, line in (("fifo", "-"), ("lifo", "--")):
                    found = _packets(measurements, panel, tracer, order)
                    if not found:
                        continue
                    sizes |= set(found)
                    mega = [interval.scaled(1e-6) for interval in found.values()]
                    _error_bars(axes, [float(n) for n in found], mega, tracer, linestyle=line)
                    rates += [interval.value for interval in mega]
                    knee = find_knee(found)
                    place = (knee, 1e-6 * found[knee].value)
                    axes.plot(*place, color=colour_of(tracer), marker=marker_of(tracer), ms=6.5)
                rates += _reference(axes, measurements, panel, tracer)
            powers_of_two(axes, sizes, max(1, len(sizes) // 4))
            axes.xaxis.set_major_formatter(FuncFormatter(power_of_two))
            # Intervals of a few repeats may be huge; the values must stay readable.
            axes.set_yscale("log")
            axes.set_ylim(0.6 * min(rates), 1.7 * max(rates))
            steps = (1.0, 2.0, 5.0) if max(rates) < 30.0 * min(rates) else (1.0,)
            axes.yaxis.set_major_locator(LogLocator(subs=steps))
            axes.yaxis.set_minor_locator(NullLocator())
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.set_title(f"{panel[0]}, {panel[1]}")
            axes.set_xlabel("rays a packet")
        for axes in all_axes[len(shown) :]:
            axes.set_axis_off()
        for axes in all_axes[::3]:
            axes.set_ylabel("million rays a second")
        orders = [
            Line2D([], [], color=INK, linestyle="-", label="first in, first out"),
            Line2D([], [], color=INK, linestyle="--", label="last in, first out"),
            Line2D([], [], color=INK, linestyle=":", label="depth_first"),
        ]
        legend(figure, [tracer for _, tracer in swept], orders)
    return figure


def power_of_two(value: float, _: object) -> str:
    """Text of an axis whose ticks are powers of two, with binary prefixes."""
    exponent = int(np.round(np.log2(value)))
    if exponent < 10:
        return str(2**exponent)
    return f"{2 ** (exponent - 10)} Ki" if exponent < 20 else f"{2 ** (exponent - 20)} Mi"


def _packets(
    measurements: Measurements, panel: Panel, tracer: str, order: str
) -> dict[int, Interval]:
    return measurements.sweep(
        "rays_per_second",
        "packet",
        scene=panel[0],
        model=panel[1],
        tracer=tracer,
        engine="packets",
        order=order,
        rays="all",
    )


def _reference(axes: Axes, measurements: Measurements, panel: Panel, tracer: str) -> list[float]:
    """Draw the same tracer's depth-first engine as a line with its interval; its rate, if any."""
    rate = measurements.find(
        "rays_per_second", scene=panel[0], model=panel[1], tracer=tracer, case="rays=all"
    )
    if rate is None:
        return []
    colour = colour_of(tracer)
    axes.axhline(1e-6 * rate.value, color=colour, ls=":", lw=1.3)
    if np.isfinite(rate.lower):
        axes.axhspan(1e-6 * rate.lower, 1e-6 * rate.upper, color=colour, alpha=0.12, lw=0)
    return [1e-6 * rate.value]
