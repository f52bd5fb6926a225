"""What features cost, in the report: the price list as a picture, and its table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from harness.report import numbers
from harness.report.style import FAINT, INK, WIDTH, figure_style
from harness.report.tables import Cell, Column, Table, columns_of, number_cell
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.prices import CUDA
from harness.tables.read import model_order, tracer_order
from harness.tables.schema import parse_case

REQUIRED, ALL = "required", "all"
TIME, REGISTERS = "feature_price", "registers"
QUANTITIES = (
    *("samples_per_second", TIME, REGISTERS, "spill_bytes", "occupancy"),
    *("instructions", "compile_seconds", "bytes_per_ray"),
)
COLOURS = "RdBu_r"
"""Blue is cheaper than what is required alone, red dearer."""
STRONGEST = {TIME: 0.3, REGISTERS: 24.0}
"""What is drawn in the full colour: a share of the time, and registers."""


@dataclass(slots=True)
class Price:
    """One program: a scene in a model with a set of features."""

    tracer: str
    model: str
    scene: str
    features: str
    found: dict[str, Interval] = field(default_factory=dict)
    """by quantity"""
    reasons: dict[str, str] = field(default_factory=dict)
    """why a quantity is not known"""


def find_prices(measurements: Measurements) -> list[Price]:
    """Collect what was measured of sets of features, in the order of the file."""
    prices: dict[tuple[str, str, str, str], Price] = {}
    for row in measurements.rows:
        features = parse_case(row.case).get("features")
        if features is None:
            continue
        key = (row.tracer, row.model, row.scene, str(features))
        price = prices.setdefault(key, Price(*key))
        if row.status == "ok":
            price.found[row.quantity] = row.interval
        else:
            price.reasons[row.quantity] = row.note
    return sorted(
        prices.values(), key=lambda one: (tracer_order(one.tracer), model_order(one.model))
    )


def price_list(prices: Sequence[Price]) -> Table | None:
    """Required against all by scene, every set of features in the CSV; None without prices."""
    if not prices:
        return None
    groups: dict[str, list[list[Cell]]] = {}
    for one in prices:
        if one.features in {REQUIRED, ALL}:
            groups.setdefault(f"{one.tracer}, {one.model}", []).append(_row(one))
    records = []
    for one in prices:
        record: dict[str, object] = {"scene": one.scene, "tracer": one.tracer, "model": one.model}
        record["features"] = one.features
        for name in QUANTITIES:
            record |= columns_of(name, one.found.get(name))
        records.append({**record, "note": "; ".join(dict.fromkeys(one.reasons.values()))})
    columns = [
        Column("scene", kind="text"),
        Column("features", kind="text"),
        Column("samples", "M/s"),
        Column("time", "× required"),
        Column("registers"),
        Column("spilled", "B"),
        Column("occupancy", "%"),
        Column("instructions"),
        Column("compiled in", "s"),
        Column("a ray", "B"),
    ]
    frame = pd.DataFrame(records)
    return Table("features", columns, list(groups.items()), frame)


def _row(one: Price) -> list[Cell]:
    def exact(name: str, factor: float = 1.0) -> Cell:
        interval = one.found.get(name)
        return Cell(numbers.MISSING if interval is None else f"{interval.value * factor:,.0f}")

    rate = number_cell(one.found.get("samples_per_second"), 1e-6)
    if "samples_per_second" in one.reasons:
        rate = Cell(numbers.MISSING, "not run here")
    return [
        Cell(one.scene, kind="text"),
        Cell(one.features, kind="text"),
        rate,
        number_cell(one.found.get(TIME)),
        exact(REGISTERS),
        exact("spill_bytes"),
        exact("occupancy", 100.0),
        exact("instructions"),
        number_cell(one.found.get("compile_seconds")),
        exact("bytes_per_ray"),
    ]


def _cost(own: Price | None, base: Price, quantity: str) -> float | None:
    """What a program costs beyond the required one: a share of its time, or registers."""
    if own is None or quantity not in own.found:
        return None
    value = own.found[quantity].value
    if quantity == TIME:
        return value - 1.0
    return value - base.found[quantity].value if quantity in base.found else None


def _is_clear(own: Price, quantity: str) -> bool:
    """Whether the interval of a ratio excludes 1; what is counted has none."""
    interval = own.found[quantity]
    return quantity != TIME or not interval.lower <= 1.0 <= interval.upper


def _draw(
    axes: Axes, scenes: Mapping[str, Mapping[str, Price]], cases: Sequence[str], quantity: str
) -> None:
    """A panel: a line a scene, a column a feature; a number is bold where it is no noise."""
    norm = TwoSlopeNorm(0.0, -STRONGEST[quantity], STRONGEST[quantity])
    image = np.full((len(scenes), len(cases)), np.nan)
    for line, of_scene in enumerate(scenes.values()):
        for place, case in enumerate(cases):
            own = of_scene.get(case)
            cost = _cost(own, of_scene[REQUIRED], quantity)
            if own is None or cost is None:
                axes.text(place, line, "·", ha="center", va="center", color=FAINT)
                continue
            image[line, place] = cost
            text = f"{100 * cost:+.0f}" if quantity == TIME else f"{cost:+.0f}"
            strong = abs(cost) > 0.6 * STRONGEST[quantity]
            axes.text(
                *(place, line, text),
                ha="center",
                va="center",
                fontsize=7,
                fontweight="bold" if _is_clear(own, quantity) else "normal",
                color="white" if strong else INK,
            )
    axes.imshow(image, cmap=COLOURS, norm=norm, aspect="auto")
    axes.set_yticks(range(len(scenes)), list(scenes))
    names = [case.removeprefix(f"{REQUIRED}+").replace("_", " ") for case in cases]
    axes.set_xticks(range(len(cases)), names, rotation=40, ha="left", rotation_mode="anchor")
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.grid(visible=False)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.axvline(len(cases) - 1.5, color=INK, lw=1.2)


def plot_prices(prices: Sequence[Price], model: str) -> Figure | None:
    """What each feature costs that a scene does not require, and all of them; None without kernels.

    Time where kernels were timed, and registers: panels one above the other.
    """
    own = [one for one in prices if one.tracer == CUDA and one.model == model]
    scenes: dict[str, dict[str, Price]] = {}
    for one in own:
        scenes.setdefault(one.scene, {})[one.features] = one
    scenes = {name: found for name, found in scenes.items() if REQUIRED in found}
    quantities = [name for name in (TIME, REGISTERS) if any(name in one.found for one in own)]
    singly = sorted({one.features for one in own} - {REQUIRED, ALL})
    if not scenes or not quantities:
        return None
    with figure_style():
        height = len(quantities) * (1.3 + 0.22 * len(scenes))
        figure = Figure(figsize=(WIDTH, height))
        panels = figure.subplots(len(quantities), 1, squeeze=False)[:, 0]
        for axes, quantity in zip(panels, quantities, strict=True):
            _draw(axes, scenes, [*singly, ALL], quantity)
            unit = "% of the time" if quantity == TIME else "registers"
            axes.set_xlabel(f"{model}: {unit} beyond what the scene requires")
    return figure


def priced_models(prices: Sequence[Price]) -> list[str]:
    """Models in which kernels were priced."""
    return list(dict.fromkeys(one.model for one in prices if one.tracer == CUDA))
