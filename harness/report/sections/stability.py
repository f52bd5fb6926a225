"""The section on what rounding costs: cracks, rays that leave a surface, precisions."""

from __future__ import annotations

from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.sections.section import Content
from harness.report.stability import (
    crack_table,
    find_crack_rows,
    mode_table,
    plot_cracks,
    surface_table,
)


def stability(material: Material, figures: FigureFiles) -> Content | None:
    """Rays lost between triangles, self-hits and leaks, and the precisions side by side."""
    rows = find_crack_rows(material.measurements)
    content = {
        "cracks": crack_table(rows),
        "surfaces": surface_table(material.measurements),
        "precisions": mode_table(material.measurements),
    }
    if not any(table is not None for table in content.values()):
        return None
    caption = material.captions["cracks"]
    figure = figures.add("cracks", plot_cracks(rows), "Rays lost between triangles", caption)
    return {**content, "crack_figure": figure}
