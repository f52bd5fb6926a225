"""Stability in the report: what is lost at edges and vertices, and what a precision changes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from harness.report import numbers
from harness.report.figures import legend
from harness.report.style import FAINT, colour_of, figure_style, make_panels, marker_of
from harness.report.tables import Cell, Column, Table
from harness.stability.aims import AIMS
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurement, Measurements
from harness.tables.read import tracer_order
from harness.tables.schema import parse_case
from harness.tables.stability import share_ppm

PARTS = ("cracks_ppm", "left_out_ppm", "outline_ppm", "false_hits_ppm")
MODE_PARTS = ("paired_bias", "diverged_ppm", "paired_speed", "non_finite_ppm")
DASHES = {"fast": (0, (3, 1.5))}
"""How a curve is drawn whose arithmetic is not the tracer's own."""


@dataclass(slots=True)
class CrackRow:
    """One tracer in one way at one mesh."""

    scene: str
    tracer: str
    traversal: str
    precision: str
    found: dict[tuple[str, float, float], dict[str, Interval]] = field(default_factory=dict)
    """by aim, scale and eye: the shares of `PARTS`"""
    reason: str = ""

    @property
    def way(self) -> str:
        """How it traces; the arithmetic is named where it is not the tracer's own."""
        return ", ".join(filter(None, [self.traversal, "fast" * (self.precision == "fast")]))

    def total(self, part: str, aim: str | None = None, eye: float | None = None) -> Interval:
        """The share over all scales, and over all aims and eyes where none is named."""
        own = [
            shares[part]
            for (own_aim, _, own_eye), shares in self.found.items()
            if part in shares and aim in (None, own_aim) and eye in (None, own_eye)
        ]
        known = [share for share in own if share.n]
        count = sum(round(share.value * 1e-6 * share.n) for share in known)
        return share_ppm(count, sum(share.n for share in known))


def find_crack_rows(measurements: Measurements) -> list[CrackRow]:
    """Collect what came of the rays at edges and vertices, tracers in the registry's order."""
    found: dict[tuple[str, str, str, str], CrackRow] = {}
    for row in measurements.rows:
        case = parse_case(row.case)
        if row.quantity not in PARTS or "aim" not in case:
            continue
        key = (row.scene, row.tracer, str(case.get("traversal", "")), row.precision)
        own = found.setdefault(key, CrackRow(*key))
        if row.status != "ok":
            own.reason = row.note
            continue
        place = (str(case["aim"]), float(case["scale"]), float(case["eye"]))
        own.found.setdefault(place, {})[row.quantity] = row.interval
    scenes = list(dict.fromkeys(row.scene for row in found.values()))
    return sorted(
        found.values(), key=lambda row: (scenes.index(row.scene), tracer_order(row.tracer))
    )


def crack_table(rows: Sequence[CrackRow]) -> Table | None:
    """Lost rays by aim, over all scales and eyes; None where nothing was traced."""
    traced = [row for row in rows if row.found]
    if not traced:
        return None
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for row in traced:
        cells = [Cell(row.tracer, kind="tracer"), Cell(row.way, kind="text")]
        record: dict[str, object] = {"scene": row.scene, "tracer": row.tracer, "way": row.way}
        for aim in AIMS:
            share = row.total("cracks_ppm", aim)
            cells.append(_share(share))
            record |= {aim: share.value, f"{aim}_upper": share.upper, f"{aim}_rays": share.n}
        for part in PARTS[1:]:
            share = row.total(part)
            cells.append(Cell(numbers.significant(share.value)))
            record[part] = share.value
        groups.setdefault(row.scene, []).append(cells)
        records.append(record)
    columns = [
        *(Column(title, kind="text") for title in ("tracer", "traversal")),
        *(Column(aim.replace("_", " "), "ppm") for aim in AIMS),
        Column("left out", "ppm"),
        Column("lost at outlines", "ppm"),
        Column("false hits", "ppm"),
    ]
    return Table("cracks", columns, list(groups.items()), pd.DataFrame(records))


def _share(share: Interval) -> Cell:
    """A share; of none the most that it can be."""
    if share.n and share.value == 0.0:
        return Cell("0", f"< {numbers.significant(share.upper, 2)}")
    return Cell(numbers.significant(share.value))


def plot_cracks(rows: Sequence[CrackRow]) -> Figure | None:
    """Lost rays over the distance of the eye, a panel an aim; None where nothing was traced.

    A tracer that loses none is drawn on the line of 0, at the bottom.
    """
    traced = _first_ways(row for row in rows if row.found)
    eyes = sorted({eye for row in traced for _, _, eye in row.found})
    if not eyes:
        return None
    shares = {
        (place, aim): [row.total("cracks_ppm", aim, eye).value for eye in eyes]
        for place, row in enumerate(traced)
        for aim in AIMS
    }
    values = [value for line in shares.values() for value in line if value > 0.0]
    least = 10.0 ** math.floor(math.log10(min(values, default=1.0))) / 10.0
    with figure_style():
        figure, all_axes = make_panels(1, len(AIMS), 2.9)
        for axes, aim in zip(all_axes, AIMS, strict=True):
            for place, row in enumerate(traced):
                line = np.array(shares[place, aim])
                axes.plot(
                    eyes,
                    np.where(line == 0.0, least, line),
                    color=colour_of(row.tracer),
                    marker=marker_of(row.tracer),
                    ls=DASHES.get(row.precision, "-"),
                    clip_on=False,
                )
            _scale(axes, least, max(values, default=10.0))
            axes.set_title(aim.replace("_", " "))
            axes.set_xlabel("eye, radii of the mesh")
        all_axes[0].set_ylabel("lost, ppm")
        legend(figure, {row.tracer for row in traced})
    return figure


def _first_ways(rows: Iterable[CrackRow]) -> list[CrackRow]:
    """A row for each tracer and precision: all traversals of one find the same."""
    first: dict[tuple[str, str], CrackRow] = {}
    for row in rows:
        first.setdefault((row.tracer, row.precision), row)
    return list(first.values())


def _scale(axes: Axes, least: float, most: float) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(least, 2.0 * most)
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda value, _: "0" if value <= least else numbers.significant(value, 1))
    )
    axes.axhline(least, color=FAINT, lw=0.8, zorder=0)


def mode_table(measurements: Measurements) -> Table | None:
    """What a precision changes in images of the same random numbers; None without any."""
    found: dict[tuple[str, str, str, str], dict[str, Measurement]] = {}
    for row in measurements.rows:
        against = str(parse_case(row.case).get("against", ""))
        if row.quantity in MODE_PARTS and against and row.status == "ok":
            key = (row.scene, row.tracer, row.precision, against)
            found.setdefault(key, {})[row.quantity] = row
    groups: dict[str, list[list[Cell]]] = {}
    records = []
    for (scene, tracer, precision, against), parts in found.items():
        own = {part: row.interval for part, row in parts.items()}
        bias = own.get("paired_bias")
        cells = [Cell(tracer, kind="tracer"), Cell(precision, kind="text")]
        cells.append(Cell(against if bias else numbers.MISSING, kind="text"))
        cells.append(
            Cell(numbers.significant(bias.value * 1e6), numbers.bounds(bias, 1e6))
            if bias
            else Cell(numbers.MISSING)
        )
        for part in MODE_PARTS[1:]:
            value = own[part].value if part in own else math.nan
            cells.append(Cell(numbers.significant(value)))
        groups.setdefault(scene, []).append(cells)
        record: dict[str, object] = {"scene": scene, "tracer": tracer, "precision": precision}
        record |= {part: interval.value for part, interval in own.items()}
        if bias:
            record |= {"lower": bias.lower, "upper": bias.upper, "against": against}
        records.append(record)
    if not groups:
        return None
    columns = [
        *(Column(title, kind="text") for title in ("tracer", "precision", "against")),
        Column("bias", "ppm"),
        Column("paths parted", "ppm"),
        Column("speed", "×"),
        Column("not finite", "ppm"),
    ]
    return Table("precisions", columns, list(groups.items()), pd.DataFrame(records))


def surface_table(measurements: Measurements) -> Table | None:
    """Self-hits over all scales and eyes, leaks by gap over all scales; None without any."""
    shares: dict[str, dict[tuple[str, float], list[Interval]]] = {}
    for row in measurements.rows:
        if row.quantity in ("self_hits_ppm", "leaks_ppm") and row.status == "ok":
            gap = float(parse_case(row.case).get("gap", 0.0))
            shares.setdefault(row.tracer, {}).setdefault((row.quantity, gap), []).append(
                row.interval
            )
    if not shares:
        return None
    heads = sorted({head for own in shares.values() for head in own}, key=lambda h: (-len(h[0]), h))
    body, records = [], []
    for tracer in sorted(shares, key=tracer_order):
        cells = [Cell(tracer, kind="tracer")]
        for head in heads:
            parts = shares[tracer].get(head, [])
            count = sum(round(part.value * 1e-6 * part.n) for part in parts)
            share = share_ppm(count, sum(part.n for part in parts))
            cells.append(_share(share))
            records.append(
                {"tracer": tracer, "quantity": head[0], "gap": head[1] or None, "ppm": share.value}
            )
        body.append(cells)
    columns = [Column("tracer", kind="text")]
    columns += [
        Column(f"leaks, gap {numbers.significant(gap, 1)}" if gap else "self-hits", "ppm")
        for _, gap in heads
    ]
    return Table("surfaces", columns, [("", body)], pd.DataFrame(records))
