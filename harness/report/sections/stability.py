"""The section on what rounding costs: how far each tracer holds, cracks, precisions."""

from __future__ import annotations

from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.sections.section import Content
from harness.report.stability_page import stability_parts, stability_tables


def stability(material: Material, figures: FigureFiles) -> Content | None:
    """The matrix with its curves, rays lost, self-hits and leaks, precisions side by side."""
    tables = stability_tables(material.measurements)
    parts = stability_parts(material.measurements, material.folder, figures.add, material.captions)
    if parts["stability_matrix"] is None and not any(
        table is not None for table in tables.values()
    ):
        return None
    return {**tables, **parts}
