"""Images of what went worst in the sweeps, side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harness.report import numbers
from harness.report.stability_matrix import power
from harness.report.style import figure_style, make_panels
from harness.stability.hazards import HAZARDS
from harness.statistics.metrics import luminance
from harness.tables.read import read_json

COLUMNS = 6
MOST = 12


def worst_rows(record: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Of each hazard the row of the largest error that has an image, at most `MOST`."""
    worst: dict[str, Mapping[str, Any]] = {}
    for row in record["rows"]:
        if "image" not in row:
            continue
        known = worst.get(row["hazard"])
        if known is None or _error(row) > _error(known):
            worst[row["hazard"]] = row
    return [worst[hazard.name] for hazard in HAZARDS if hazard.name in worst][:MOST]


def _error(row: Mapping[str, Any]) -> float:
    return abs(row["error"]["value"]) if row["status"] == "ok" else math.inf


def plot_worst(results_dir: Path) -> Figure | None:
    """The images of `worst_rows`, grey from nothing to twice what they must show.

    None where no sweep was run, or nothing went wrong. Pixels that are no numbers are red.
    """
    path = results_dir / "stability" / "sweeps.json"
    if not path.exists():
        return None
    rows = worst_rows(read_json(path))
    if not rows:
        return None
    hazards = {hazard.name: hazard for hazard in HAZARDS}
    columns = min(COLUMNS, max(len(rows), 3))
    with figure_style():
        figure, all_axes = make_panels(-(-len(rows) // columns), columns, 2.3)
        for axes in all_axes:
            axes.set_axis_off()
        for axes, row in zip(all_axes, rows, strict=False):
            hazard = hazards[row["hazard"]]
            extreme = hazard.make(row["value"])
            name = f"{row['hazard']}-{row['value']:g}"
            image = np.load(path.parent / "sweeps" / name / row["image"], allow_pickle=False)
            axes.imshow(_grey(image, extreme.unit), interpolation="nearest")
            own = row["case"][hazard.key]
            value = own.replace("_", " ") if isinstance(own, str) else power(float(own))
            error = numbers.percent(_error(row), 1)
            axes.set_title(f"{row['hazard'].replace('_', ' ')} {value}", fontsize=8)
            axes.text(
                *(0.0, -0.04),
                f"{row['tracer']}, {row['precision']}\nerror {error.lstrip('+')} %",
                transform=axes.transAxes,
                va="top",
                fontsize=7.5,
            )
    return figure


def _grey(image: NDArray[np.floating], unit: float) -> NDArray[np.float64]:
    """Luminance over twice the unit, [h, w, 3] in 0 .. 1; red where there is none."""
    grey = luminance(image.astype(np.float64)) / (2.0 * unit)
    colour = np.repeat(np.clip(np.nan_to_num(grey), 0.0, 1.0)[..., None], 3, axis=-1)
    colour[~np.isfinite(grey)] = (0.8, 0.1, 0.1)
    return colour
