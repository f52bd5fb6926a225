"""How far every tracer can be pushed: one cell a hazard, one curve behind each cell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from harness.report.figures import legend
from harness.report.style import FAINT, INK, colour_of, figure_style, make_panels, marker_of
from harness.stability.hazards import HAZARDS, KINDS
from harness.tables.lookup import Measurement, Measurements
from harness.tables.read import tracer_order
from harness.tables.schema import parse_case

TOLERANCE = 1e-3
"""Relative error of an image within which a value holds."""

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MODES = ("fp64", "watertight", "robust", "native", "fast")
"""Order of the precisions of a tracer."""
DASHES: Mapping[str, object] = {"fast": (0, (3, 1.5)), "fp64": (0, (1, 1.2))}


@dataclass(frozen=True, slots=True)
class Line:
    """One row of the matrix: what is pushed, what is measured, and which rows those are."""

    name: str
    title: str
    quantity: str
    key: str
    family: str
    held: Mapping[str, object] = field(default_factory=dict)
    """what else a row's case must have: what is not pushed is mild"""

    def takes(self, row: Measurement, case: Mapping[str, object]) -> bool:
        """Whether a row of the table belongs here."""
        mild = all(case.get(key) == value for key, value in self.held.items())
        return row.quantity == self.quantity and self.key in case and mild


FAMILIES = {
    "rays": "Rays",
    "places": "Places and sizes",
    "lights": "Lights and views",
    "surfaces": "Surfaces and sums",
}
"""Titles of the figures, by family."""

_FAMILY_OF = {
    **dict.fromkeys(("scale", "distance", "distance_recentred", "eye"), "places"),
    **dict.fromkeys(("light_distance", "light_size", "radiance", "grazing"), "lights"),
}

LINES: tuple[Line, ...] = (
    Line("cracks_scale", "cracks, scale of the mesh", "cracks_ppm", "scale", "rays", {"eye": 1.0}),
    Line("cracks_eye", "cracks, distance of the eye", "cracks_ppm", "eye", "rays", {"scale": 1.0}),
    Line("self_hits_scale", "self-hits, scale", "self_hits_ppm", "scale", "rays", {"eye": 1.0}),
    Line(
        *("self_hits_eye", "self-hits, distance of the eye", "self_hits_ppm", "eye", "rays"),
        {"scale": 1.0},
    ),
    Line("leaks_scale", "leaks, scale", "leaks_ppm", "scale", "rays", {"gap": 0.01}),
    Line("leaks_gap", "leaks, gap under a lid", "leaks_ppm", "gap", "rays", {"scale": 1.0}),
    *(
        Line(
            hazard.name,
            hazard.title,
            "closed_form_error",
            hazard.key,
            _FAMILY_OF.get(hazard.name, "surfaces"),
            {"recentred": hazard.case(1.0)["recentred"]} if hazard.key == "distance" else {},
        )
        for hazard in HAZARDS
    ),
)
"""Rows of the matrix, in its order."""

DOWNWARDS = frozenset({"leaks_gap", "grazing"})
"""Where small is extreme, and no value is on the other side."""


@dataclass(frozen=True, slots=True)
class Point:
    """What was measured at one value: error is the largest of its rows, a share or ppm."""

    error: float
    verdict: str
    """pass, fail, or wait for an interval that is too wide to say"""
    reason: str = ""


@dataclass(slots=True)
class Curve:
    """One tracer in one precision, pushed along one line: points by value."""

    points: dict[float, Point] = field(default_factory=dict)
    absent: str = ""
    """why there is nothing, where there is none"""


Subject = tuple[str, str]
"""Tracer and precision."""


def find_curves(measurements: Measurements) -> dict[str, dict[Subject, Curve]]:
    """Collect the curves by line; empty where nothing was pushed.

    Several rows of one value (aims, traversals) are one point, which the worst of them decides.
    """
    curves: dict[str, dict[Subject, Curve]] = {}
    quantities = {line.quantity for line in LINES}
    for row in measurements.rows:
        if row.quantity not in quantities:
            continue
        case = parse_case(row.case)
        for line in LINES:
            if not line.takes(row, case):
                continue
            subject = (row.tracer, row.precision)
            curve = curves.setdefault(line.name, {}).setdefault(subject, Curve())
            if row.status == "skipped":
                curve.absent = row.note
                continue
            own = case[line.key]
            value = float(KINDS.index(own)) if isinstance(own, str) else float(own)
            point, known = _point(row), curve.points.get(value)
            if known is None or _badness(point) > _badness(known):
                curve.points[value] = point
    return curves


def _point(row: Measurement) -> Point:
    if row.status != "ok":
        return Point(math.inf, "fail", row.note)
    if row.quantity != "closed_form_error":
        return Point(row.interval.value, "pass" if row.interval.value == 0.0 else "fail")
    low, high = row.interval.lower, row.interval.upper
    error = abs(row.interval.value)
    if low >= -TOLERANCE and high <= TOLERANCE:
        return Point(error, "pass")
    return Point(error, "fail" if low > TOLERANCE or high < -TOLERANCE else "wait")


def _badness(point: Point) -> tuple[int, float]:
    return ("pass", "wait", "fail").index(point.verdict), point.error


@dataclass(frozen=True, slots=True)
class Held:
    """How far one curve holds: a cell of the matrix."""

    kind: str
    """pass where every value holds, wait where some do, fail where the mildest fails; empty where
    there is nothing"""
    text: str
    note: str
    target: str
    """the figure that has the curve"""


def power(value: float) -> str:
    """A power of ten as such, another number in three digits."""
    if value > 0.0:
        exponent = round(math.log10(value))
        if exponent in (-1, 0, 1):
            return f"{value:g}"
        if math.isclose(value, 10.0**exponent, rel_tol=1e-9):
            return "10" + str(exponent).translate(SUPERSCRIPTS)
    return f"{value:.3g}"


def held(line: Line, curve: Curve) -> Held:
    """How far a curve holds, from its mildest value outwards."""
    target = f"stability-{line.family}"
    if not curve.points:
        return Held("", "–", curve.absent, target)
    values = sorted(curve.points)
    if line.name == "triangles":
        return _held_kinds(curve, target)
    mild = _mildest(line, values)
    place = values.index(mild)
    if curve.points[mild].verdict != "pass":
        unsure = curve.points[mild].verdict == "wait"
        return Held("wait" if unsure else "fail", "unsure" if unsure else "none", "", target)
    above = _last(curve, values[place:])
    below = _last(curve, values[: place + 1][::-1])
    every = above == values[-1] and below == values[0]
    first = [value for value in values if not below <= value <= above]
    near = min(first, key=lambda value: abs(math.log(value / mild)), default=None)
    note = "" if near is None else f"first not held: {power(near)}"
    if line.name in DOWNWARDS:
        text = power(below)
    elif place == 0:
        text = power(above)
    else:
        text = f"{power(below)} … {power(above)}"
    return Held("pass" if every else "wait", text, note, target)


def _mildest(line: Line, values: Sequence[float]) -> float:
    if line.name in DOWNWARDS:
        return values[-1]
    if line.key in ("scale", "radiance", "light_distance", "light_size"):
        return min(values, key=lambda value: abs(math.log(value)))
    return values[0]


def _last(curve: Curve, values: Sequence[float]) -> float:
    """The last value before the first that does not hold."""
    last = values[0]
    for value in values:
        if curve.points[value].verdict != "pass":
            break
        last = value
    return last


def _held_kinds(curve: Curve, target: str) -> Held:
    wrong = [KINDS[int(v)] for v, point in curve.points.items() if point.verdict != "pass"]
    if not wrong:
        return Held("pass", "all", "", target)
    kind = "fail" if len(wrong) == len(curve.points) else "wait"
    return Held(kind, "not " + ", ".join(wrong).replace("_", " "), "", target)


@dataclass(frozen=True, slots=True)
class Matrix:
    """What the page draws: a column a tracer and precision, a row a hazard."""

    tracers: list[tuple[str, list[str]]]
    rows: list[tuple[str, list[Held]]]


def make_stability_matrix(curves: Mapping[str, Mapping[Subject, Curve]]) -> Matrix | None:
    """The matrix; None without any curve."""
    subjects = sorted({subject for own in curves.values() for subject in own}, key=_order)
    shown = [
        subject
        for subject in subjects
        if any(own[subject].points for own in curves.values() if subject in own)
    ]
    if not shown:
        return None
    heads: dict[str, list[str]] = {}
    for tracer, precision in shown:
        heads.setdefault(tracer, []).append(precision)
    rows = [
        (line.title, [held(line, curves[line.name].get(s, Curve())) for s in shown])
        for line in LINES
        if line.name in curves
    ]
    return Matrix(list(heads.items()), rows)


def _order(subject: Subject) -> tuple[int, int]:
    tracer, precision = subject
    place = MODES.index(precision) if precision in MODES else len(MODES)
    return tracer_order(tracer), place


def plot_family(curves: Mapping[str, Mapping[Subject, Curve]], family: str) -> Figure | None:
    """The curves of a family, a panel a line; None without any."""
    lines = [
        line
        for line in LINES
        if line.family == family and line.name != "triangles" and line.name in curves
    ]
    lines = [line for line in lines if any(c.points for c in curves[line.name].values())]
    if not lines:
        return None
    # Titles are as wide as half of the page.
    columns = min(len(lines), 2)
    with figure_style():
        figure, all_axes = make_panels(-(-len(lines) // columns), columns, 2.4)
        for axes in all_axes[len(lines) :]:
            axes.set_visible(False)
        for axes, line in zip(all_axes, lines, strict=False):
            _plot(axes, line, curves[line.name])
        shown = [s for line in lines for s, curve in curves[line.name].items() if curve.points]
        styles = [name for name in DASHES if any(precision == name for _, precision in shown)]
        extra = [Line2D([], [], color=INK, ls=DASHES[name], lw=1.2, label=name) for name in styles]
        legend(figure, {tracer for tracer, _ in shown}, extra)
    return figure


def _plot(axes: Axes, line: Line, curves: Mapping[Subject, Curve]) -> None:
    """One panel. What is 0 is drawn at the bottom, what is no number at the top."""
    ppm = line.quantity != "closed_form_error"
    found = [
        point.error
        for curve in curves.values()
        for point in curve.points.values()
        if 0.0 < point.error < math.inf
    ]
    smallest, largest = min(found, default=1.0), max(found, default=10.0)
    least = 10.0 ** (math.floor(math.log10(smallest)) - 1) if ppm else 1e-8
    most = max(3.0 * largest, 10.0 * least)
    for (tracer, precision), curve in sorted(curves.items(), key=lambda item: _order(item[0])):
        values = sorted(curve.points)
        errors = np.clip([curve.points[value].error for value in values], least, 0.7 * most)
        axes.plot(
            values,
            errors,
            color=colour_of(tracer),
            marker=marker_of(tracer),
            mfc="white",
            ls=DASHES.get(precision, "-"),
            lw=1.2,
            ms=3.5,
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    # Room for half of a marker.
    axes.set_ylim(least * (least / most) ** 0.04, most)
    axes.xaxis.set_major_locator(LogLocator(numticks=7))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_locator(LogLocator(numticks=6))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: "0" if value <= least else power(value))
    )
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: power(value)))
    if not ppm:
        axes.axhline(TOLERANCE, color=FAINT, lw=0.9, ls="--", zorder=0)
    if line.name in DOWNWARDS:
        axes.invert_xaxis()
    axes.set_title(line.title)
    axes.set_ylabel("ppm" if ppm else "error")
