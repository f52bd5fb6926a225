"""Links to a view of the viewer, and the place of an image that is worth a look."""

from __future__ import annotations

from urllib.parse import quote

import numpy as np

from harness.statistics.metrics import Truth, luminance
from harness.statistics.tiles import TILE, tile_means
from harness.tables.read import SceneJob

Place = tuple[float, float]
"""x and y in pixels of the image as the tracer made it, from its upper left corner."""


def link_of(
    scene: str,
    model: str,
    tracer: str,
    *,
    mode: str = "relative",
    place: Place | None = None,
    zoom: float = 1.0,
) -> str:
    """Address of a view within the report: an image beside the truth, centred at a place."""
    parts = [f"view={quote(scene, safe='')}/{quote(model, safe='')}/{quote(tracer, safe='')}"]
    parts.append(f"mode={mode}")
    if place is not None:
        parts.append(f"x={place[0]:g}&y={place[1]:g}")
    if zoom != 1.0:
        parts.append(f"zoom={zoom:g}")
    return "#" + "&".join(parts)


def worst_place(job: SceneJob, model: str, tracer: str, tile: int = TILE) -> Place | None:
    """Centre of the tile whose mean luminance is furthest from the truth's, over their errors.

    |x - r| / sqrt(s_x^2 + s_r^2 + u^2), where u is a ten-thousandth of the image's mean luminance:
    without it, tiles without noise would win by a rounding error. None if the tracer has no images.
    Raises ResultsError for missing or damaged files.
    """
    found = job.seeds(model, tracer)
    if found is None or not found.seeds:
        return None
    truth: Truth = job.truth(model)
    sides = [tile_means(side, tile) for side in (found.images.astype(np.float64), truth.batches)]
    broken = ~np.isfinite(sides[0]).all(axis=0)
    variance = sum(side.var(axis=0, ddof=1) / len(side) for side in sides if len(side) > 1)
    floor = 1e-4 * float(luminance(truth.mean).mean())
    difference = np.abs(sides[0].mean(axis=0) - sides[1].mean(axis=0))
    score = difference / np.sqrt(variance + max(floor, 1e-30) ** 2)
    score[broken] = np.inf
    row, column = np.unravel_index(int(np.argmax(score)), score.shape)
    right, bottom = min((column + 1) * tile, job.width), min((row + 1) * tile, job.height)
    return (float(column * tile + right) / 2.0, float(row * tile + bottom) / 2.0)
