"""The plane of the trade: the time that an image is given against the error that is left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from harness.report import numbers
from harness.report.style import (
    FAINT,
    INK,
    colour_of,
    figure_style,
    make_panels,
    marker_of,
)
from harness.report.turns import (
    extend,
    knob_of,
    name_of_turn,
    only_turned,
    turn_order,
    turned_of,
)
from harness.statistics.intervals import Interval
from harness.statistics.trade import error_curve
from harness.tables.knobs import UNBIASED
from harness.tables.lookup import Measurements
from harness.tables.read import model_order, tracer_order
from harness.tables.schema import parse_case
from harness.tables.trade import BUDGETS, EXACT

EARLIEST, USUAL, LATEST = 1e-4, 0.03, 300.0
"""Seconds that are drawn: the budgets, what is next to them, and crossovers of GPUs before them."""
POINTS_A_DECADE = 10
LOWEST, HIGHEST = 1e-6, 10.0
"""Errors beyond these are cut off: the one is far below any truth's noise, the other no picture."""
MODEL_LINES = {"path": "-", "haste": "--", "whitted": ":"}
FRONT = "#f0c54a"
KNOB_STYLES = {"rr_depth": ("#d55e00", "--"), "clamp": ("#a8438b", "-."), "film": (INK, ":")}


class Subject(Protocol):
    """A scene: its job, or what of it is needed where only its measurements are left."""

    @property
    def name(self) -> str:
        """As its folder and the tables call it."""
        ...

    @property
    def description(self) -> Mapping[str, Any]:
        """With `settings.max_depth`, where it is known."""
        ...


@dataclass(frozen=True, slots=True)
class Curve:
    """A tracer, model and setting of the knobs as bias and time to unit variance."""

    tracer: str
    model: str
    turned: dict[str, Any]
    """what was turned; empty for the settings of the scene"""
    bias_squared: Interval
    ttuv: Interval
    crossover: Interval | None
    """time up to which it is better than the same tracer's exact variant"""
    speed_up: Interval | None = None
    """how much sooner than the exact variant it reaches the same variance"""
    look: dict[str, Any] = field(default_factory=dict)

    def errors(self, seconds: NDArray[np.float64]) -> NDArray[np.float64]:
        """RelMSE at those times with its bounds: [3, N]."""
        return error_curve(seconds, self.bias_squared, self.ttuv)

    def styled(self, **look: Any) -> Curve:
        """The same curve, drawn otherwise."""
        return replace(self, look=look)


def curves_of(measurements: Measurements, job: Subject) -> list[Curve]:
    """All ways to the exact picture of a scene, in the order of tracers and models.

    `haste` and `whitted`, which have no solid angle, after their exposure was set; `path` as it is.
    The error of the scene's own depth limit counts where it was measured.
    """
    rows = [row for row in measurements.rows if row.scene == job.name and row.status == "ok"]
    index = {
        (row.quantity, row.tracer, row.model, row.engine, row.case): row.interval for row in rows
    }
    limit = limit_bias(measurements, job)
    found = []
    for row in rows:
        case = parse_case(row.case)
        exposure = case.get("exposure")
        if row.quantity != "relative_ttuv_seconds":
            continue
        if exposure == "scaled" if row.model == EXACT else exposure != "scaled":
            continue
        turned = turned_of(case)
        here = (row.tracer, row.model, row.engine)
        nothing = Interval(0.0, 0.0, 0.0, 0)
        bias = index.get(("relative_bias_squared", *here, row.case), nothing)
        star = index.get(("crossover_seconds", *here, extend(row.case, to=row.tracer)))
        unbiased = row.model == EXACT and bool(UNBIASED & turned.keys())
        found.append(
            Curve(
                row.tracer,
                row.model,
                turned,
                limit or nothing if not row.case else nothing if unbiased else bias,
                row.interval,
                None if unbiased else star,
                index.get(("speed_up", *here, extend(only_turned(row.case), to=row.tracer)))
                if turned
                else None,
            )
        )
    return sorted(
        found,
        key=lambda curve: (
            tracer_order(curve.tracer),
            model_order(curve.model),
            turn_order(curve.turned),
        ),
    )


def limit_bias(measurements: Measurements, job: Subject) -> Interval | None:
    """Squared bias of the scene's own depth limit, by the first tracer that has swept it."""
    depth = job.description.get("settings", {}).get("max_depth")
    case = f"exposure=raw;max_depth={depth}"
    for tracer in measurements.tracers("relative_bias_squared", job.name, EXACT):
        where = {"scene": job.name, "model": EXACT, "tracer": tracer}
        found = measurements.find("relative_bias_squared", case=case, **where)
        if found is not None:
            return found
    return None


def seconds_of(curves: Sequence[Curve]) -> NDArray[np.float64]:
    """Times to draw curves at: from `EARLIEST` on where any crosses another before `USUAL`."""
    stars = [curve.crossover.value for curve in curves if curve.crossover is not None]
    first = EARLIEST if any(EARLIEST < star < USUAL for star in stars) else USUAL
    return np.geomspace(first, LATEST, round(POINTS_A_DECADE * math.log10(LATEST / first)) + 1)


def front_of(curves: Sequence[Curve], seconds: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least error of any curve at each time: the Pareto front of time and error."""
    errors = np.array([curve.errors(seconds)[0] for curve in curves])
    return np.asarray(np.where(errors > 0.0, errors, np.inf).min(axis=0))


@dataclass(frozen=True, slots=True)
class Panel:
    """Curves that are drawn together."""

    title: str
    curves: list[Curve]
    own_picture: bool = False
    """whether errors are against the model's own picture: other errors than those of the rest"""


def plot_trade(measurements: Measurements, job: Subject) -> Figure | None:
    """Panels of tracers, models and knobs on one plane; None where `path` was not timed.

    In all of them the same front of all curves, and lines of equal efficiency; but for the sample
    counts of `haste`, whose noise alone is drawn: they do not change its bias.
    """
    curves = curves_of(measurements, job)
    if not any(curve.model == EXACT for curve in curves):
        return None
    panels = _panels(curves)
    seconds = seconds_of(curves)
    front = front_of(curves, seconds)
    with figure_style():
        figure, all_axes = make_panels(-(-len(panels) // 2), 2, 3.3)
        limits = _limits(curves, seconds)
        for axes, panel in zip(all_axes, panels, strict=False):
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xlim(seconds[0], seconds[-1])
            axes.set_ylim(*(_limits(panel.curves, seconds) if panel.own_picture else limits))
            _equal_efficiency(axes)
            if not panel.own_picture:
                axes.plot(seconds, front, color=FRONT, lw=6.0, alpha=0.55, zorder=1)
            for curve in panel.curves:
                _draw(axes, curve, seconds)
            axes.xaxis.set_major_locator(LogLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(_tick))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.yaxis.set_minor_locator(NullLocator())
            axes.set_title(panel.title)
            axes.set_xlabel("seconds for an image")
            axes.set_ylabel("relative variance" if panel.own_picture else "relMSE")
            axes.legend(
                handles=[_entry(curve) for curve in panel.curves],
                loc="upper left",
                bbox_to_anchor=(1.01, 1.03),
                borderaxespad=0.0,
                handlelength=2.4,
                fontsize=7.5,
            )
        for axes in all_axes[len(panels) :]:
            axes.set_axis_off()
        figure.legend(
            handles=[
                Patch(color=FRONT, alpha=0.55, label="Pareto front through all curves"),
                Line2D([], [], color=FAINT, ls="--", lw=0.8, label="equal efficiency"),
                Line2D([], [], color=INK, marker="o", mfc="white", lw=1.0, label="T*, 95 %"),
                Patch(color=FAINT, alpha=0.3, label="95 % of an error"),
            ],
            loc="outside upper left",
            ncols=4,
            borderaxespad=0.2,
        )
    return figure


def _panels(curves: Sequence[Curve]) -> list[Panel]:
    plain = [
        curve.styled(
            color=colour_of(curve.tracer),
            marker=marker_of(curve.tracer),
            ls=MODEL_LINES[curve.model],
        )
        for curve in curves
        if not curve.turned
    ]
    panels = [Panel("tracers of path", [curve for curve in plain if curve.model == EXACT])]
    several = {curve.tracer for curve in plain if curve.model != EXACT}
    if several:
        models = [curve for curve in plain if curve.tracer in several]
        panels.append(Panel("models, their exposure set", models))
    for tracer in dict.fromkeys(curve.tracer for curve in curves if curve.turned):
        own = [curve for curve in curves if curve.turned and curve.tracer == tracer]
        path = [curve for curve in own if curve.model == EXACT]
        haste = [
            replace(curve, bias_squared=Interval(0.0, 0.0, 0.0, 0), crossover=None)
            for curve in own
            if curve.model != EXACT
        ]
        if path:
            panels.append(Panel(f"knobs of path, {tracer}", _styled_knobs(path)))
        if haste:
            panels.append(Panel(f"samples a hit of haste, {tracer}", _styled_knobs(haste), True))
    return panels


def _styled_knobs(curves: Sequence[Curve]) -> list[Curve]:
    """Depth limits and sample counts along a scale of colours, other knobs each in its own."""
    scale = [curve for curve in curves if knob_of(curve.turned) not in KNOB_STYLES]
    shades = colormaps["viridis"](np.linspace(0.0, 0.85, max(len(scale), 2)))
    seen: dict[str, int] = {}
    found = []
    for curve in curves:
        knob = knob_of(curve.turned)
        if knob in KNOB_STYLES:
            colour, line = KNOB_STYLES[knob]
            seen[knob] = seen.get(knob, 0) + 1
            marker = "sX^v"[min(seen[knob], 4) - 1]
            found.append(curve.styled(color=colour, ls=line, marker=marker))
        else:
            place = scale.index(curve)
            marker = ".oDPsv*hX^"[place % 10]
            found.append(curve.styled(color=tuple(shades[place]), marker=marker))
    return found


def _limits(curves: Sequence[Curve], seconds: NDArray[np.float64]) -> tuple[float, float]:
    errors = np.concatenate([curve.errors(seconds)[0] for curve in curves])
    shown = errors[(errors > LOWEST) & (errors < HIGHEST)]
    return 0.6 * float(shown.min()), 1.6 * float(shown.max())


def _draw(axes: Axes, curve: Curve, seconds: NDArray[np.float64]) -> None:
    look = {"ls": "-", "lw": 1.3} | curve.look
    marker = look.pop("marker", "")
    value, lower, upper = curve.errors(seconds)
    floor = axes.get_ylim()[0]
    axes.fill_between(
        seconds, np.maximum(lower, 0.1 * floor), upper, color=look["color"], alpha=0.13, lw=0
    )
    axes.plot(seconds, value, zorder=3, **look)
    at = np.array(BUDGETS)
    axes.plot(at, curve.errors(at)[0], ls="", marker=marker, ms=4.0, color=look["color"], zorder=3)
    star = curve.crossover
    if star is None or not (seconds[0] < star.value < seconds[-1]):
        return
    height = float(curve.errors(np.array([star.value]))[0, 0])
    ends = np.clip([star.lower, star.upper], seconds[0], seconds[-1])
    axes.plot(ends, [height, height], color=look["color"], lw=1.6, zorder=4)
    axes.plot(
        star.value, height, marker="o", ms=6.0, mfc="white", mec=look["color"], mew=1.4, zorder=5
    )


def _tick(value: float, _: int) -> str:
    return f"{value:g}" if value > 0.0005 else f"1e−{-math.log10(value):.0f}"


def _entry(curve: Curve) -> Line2D:
    look = {"ls": "-", "lw": 1.3} | curve.look
    text = name_of_turn(curve.turned) or f"{curve.tracer} {curve.model}"
    if curve.crossover is not None:
        text += f"{'  ' if curve.turned else chr(10)}T* {_time(curve.crossover)}"
    elif curve.speed_up is not None:
        text += f"  {numbers.significant(curve.speed_up.value, 2)} times"
    return Line2D([], [], label=text, ms=4.5, **look)


def _time(found: Interval) -> str:
    if found.value <= 0.0:
        return "never" if found.upper <= 0.0 else "0 s"
    if math.isinf(found.value):
        return f"> {_two_digits(found.lower)}" if found.lower > 0.0 else "unknown"
    return _two_digits(found.value)


def _two_digits(value: float) -> str:
    return f"{numbers.significant(value, 2)} s"


def _equal_efficiency(axes: Axes) -> None:
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    ends = np.array([left, right])
    for exponent in range(math.floor(math.log10(left * low)), math.ceil(math.log10(right * high))):
        axes.plot(ends, 10.0**exponent / ends, color=FAINT, ls="--", lw=0.6, alpha=0.5, zorder=0)
