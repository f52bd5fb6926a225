"""The stability page: the matrix, its curves, what a precision costs and saves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from harness.report import numbers
from harness.report.stability import (
    crack_table,
    find_crack_rows,
    mode_table,
    plot_cracks,
    surface_table,
)
from harness.report.stability_matrix import (
    FAMILIES,
    MODES,
    find_curves,
    make_stability_matrix,
    plot_family,
)
from harness.report.stability_worst import plot_worst
from harness.report.tables import Cell, Column, Table
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurement, Measurements
from harness.tables.read import tracer_order
from harness.tables.schema import parse_case
from harness.tables.stability import share_ppm

RATE_OF = "diffuse1"
"""Class of rays whose rate stands for a precision: rays of no order."""
SHARES = ("cracks_ppm", "self_hits_ppm", "leaks_ppm", "non_finite_ppm")

AddFigure = Callable[[str, Figure | None, str, str], Any]


def stability_tables(measurements: Measurements) -> dict[str, Table | None]:
    """The tables of the page, by the names that its template has for them."""
    return {
        "cracks": crack_table(find_crack_rows(measurements)),
        "precisions": mode_table(measurements),
        "surfaces": surface_table(measurements),
        "stability_trade": trade_table(measurements),
    }


def stability_parts(
    measurements: Measurements, results_dir: Path, add: AddFigure, captions: Mapping[str, str]
) -> dict[str, Any]:
    """Everything else that the template wants.

    Parameters
    ----------
    measurements
        The rows of measurements.csv.
    results_dir
        The run's folder, which has the images of the sweeps.
    add
        Writes a figure and makes it part of the page; of name, figure, title and caption.
    captions
        The texts of harness/captions.
    """
    curves = find_curves(measurements)
    crack_figure = plot_cracks(find_crack_rows(measurements))
    families = [
        (
            f"stability-{family}",
            add(f"stability-{family}", plot_family(curves, family), title, ""),
        )
        for family, title in FAMILIES.items()
    ]
    return {
        "stability_matrix": make_stability_matrix(curves),
        "stability_lines": trade_lines(measurements),
        "stability_figures": [(anchor, figure) for anchor, figure in families if figure],
        "worst_figure": add(
            "stability-worst",
            plot_worst(results_dir),
            "The worst side by side",
            captions["stability_worst"],
        ),
        "crack_figure": add("cracks", crack_figure, "Cracks", captions["cracks"]),
    }


def _shares(measurements: Measurements) -> dict[tuple[str, str], dict[str, Interval]]:
    """Shares of everything that was counted, by tracer and precision, over all cases."""
    parts: dict[tuple[str, str], dict[str, list[Interval]]] = {}
    for row in measurements.rows:
        case = parse_case(row.case)
        ours = row.quantity != "non_finite_ppm" or "against" in case
        if row.quantity in SHARES and row.status == "ok" and ours and row.interval.n:
            own = parts.setdefault((row.tracer, row.precision), {})
            own.setdefault(row.quantity, []).append(row.interval)
    return {
        subject: {
            quantity: share_ppm(
                sum(round(one.value * 1e-6 * one.n) for one in found), sum(one.n for one in found)
            )
            for quantity, found in own.items()
        }
        for subject, own in parts.items()
    }


def _rates(measurements: Measurements) -> dict[tuple[str, str], tuple[str, float]]:
    """Scene and rays a second of the fastest way of each tracer and precision.

    All on one scene: the first that the benchmark of rays has.
    """
    found: dict[tuple[str, str], tuple[str, float]] = {}
    scene = ""
    for row in measurements.rows:
        wanted = row.quantity == "rays_per_second" and row.status == "ok"
        if not wanted or parse_case(row.case).get("rays") != RATE_OF:
            continue
        scene = scene or row.scene
        key = (row.tracer, row.precision)
        if row.scene == scene and row.interval.value > found.get(key, ("", 0.0))[1]:
            found[key] = (scene, row.interval.value)
    return found


def _biases(measurements: Measurements) -> dict[tuple[str, str, str], Measurement]:
    """By scene, tracer and precision."""
    return {
        (row.scene, row.tracer, row.precision): row
        for row in measurements.rows
        if row.quantity == "paired_bias" and row.status == "ok"
    }


def trade_table(measurements: Measurements) -> Table | None:
    """Speed, everything that was lost, and the largest bias, by tracer and precision."""
    shares, rates, biases = _shares(measurements), _rates(measurements), _biases(measurements)
    pushed = {subject for subject, own in shares.items() if "cracks_ppm" in own or len(own) > 1}
    if not pushed:
        return None
    body, records = [], []
    for tracer, precision in sorted(pushed, key=_order):
        own, rate = shares[tracer, precision], rates.get((tracer, precision))
        moved = [row for (_, *subject), row in biases.items() if subject == [tracer, precision]]
        worst = max(moved, key=lambda row: abs(row.interval.value), default=None)
        record: dict[str, object] = {"tracer": tracer, "precision": precision}
        cells = [Cell(tracer, kind="tracer"), Cell(precision, kind="text")]
        cells.append(Cell(numbers.significant(rate[1] * 1e-6) if rate else numbers.MISSING))
        record["rays_per_second"] = rate[1] if rate else None
        for quantity in SHARES:
            share = own.get(quantity)
            cells.append(_share(share))
            record[quantity] = share.value if share else None
            record[f"{quantity}_upper"] = share.upper if share else None
        bias = worst.interval if worst else None
        cells.append(
            Cell(numbers.significant(bias.value * 1e6), numbers.bounds(bias, 1e6))
            if bias
            else Cell(numbers.MISSING)
        )
        cells.append(Cell(worst.scene if worst else "", kind="text"))
        record |= {"paired_bias": bias.value if bias else None}
        record |= {"paired_bias_scene": worst.scene if worst else None}
        body.append(cells)
        records.append(record)
    scene = next((scene for scene, _ in rates.values()), "")
    columns = [
        *(Column(title, kind="text") for title in ("tracer", "precision")),
        Column("rays a second", f"M, {RATE_OF}, {scene}" if scene else "M"),
        *(Column(title, "ppm") for title in ("cracks", "self-hits", "leaks", "not finite")),
        Column("largest bias", "ppm"),
        Column("of", kind="text"),
    ]
    return Table("stability_trade", columns, [("", body)], pd.DataFrame(records))


def _share(share: Interval | None) -> Cell:
    """A share; of none the most that it can be."""
    if share is None:
        return Cell(numbers.MISSING)
    if share.value == 0.0:
        return Cell("0", f"< {numbers.significant(share.upper, 2)}")
    return Cell(numbers.significant(share.value))


def _order(subject: tuple[str, str]) -> tuple[int, int]:
    tracer, precision = subject
    return tracer_order(tracer), MODES.index(precision) if precision in MODES else len(MODES)


def trade_lines(measurements: Measurements) -> list[str]:
    """One sentence a scene and tracer: what fast arithmetic gains there, and what it moves."""
    speeds = {
        (row.scene, row.tracer, row.precision): row.interval.value
        for row in measurements.rows
        if row.quantity == "paired_speed" and row.status == "ok"
    }
    lines = []
    for (scene, tracer, precision), row in _biases(measurements).items():
        if precision != "fast":
            continue
        against = str(parse_case(row.case)["against"])
        speed = speeds.get((scene, tracer, "fast"))
        base = speeds.get((scene, tracer, "watertight"), 1.0)
        if speed is None:
            continue
        gain = speed / base
        value = numbers.significant(row.interval.value * 1e6, 2)
        ends = numbers.bounds(row.interval, 1e6, 2)
        lines.append(
            f"{scene}, {tracer}: fast arithmetic renders at {gain:.2f} times the speed of "
            f"watertight, and its mean lies {value} ppm {ends} from that of {against}."
        )
    return lines
