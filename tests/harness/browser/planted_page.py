"""A report of fabricated results with two planted errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from harness.report.write import write_report
from harness.statistics.tiles import TILE
from harness.tables import write_tables

FAILURES = (("cornell-box", "path", "embree"), ("mirror-glass", "haste", "haste-cpu"))
"""Scene, model and tracer whose image is 5 % too bright, and one with a wrong tile."""
TILE_AT = (2, 1)
"""Row and column of that tile."""


def plant(folder: Path) -> Path:
    """Change the images of FAILURES in fabricated results, and write their report."""
    row, column = TILE_AT
    place = (slice(row * TILE, (row + 1) * TILE), slice(column * TILE, (column + 1) * TILE))
    for which, (scene, model, tracer) in enumerate(FAILURES):
        for path in (folder / "scenes" / scene / "seeds" / model / tracer).glob("*.npy"):
            image = np.load(path)
            image[place if which else ...] *= np.float32(1.4 if which else 1.05)
            np.save(path, image)
    write_tables(folder)
    return write_report(folder)
