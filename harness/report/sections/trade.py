"""Sections on what speed costs: the planes of time and error, what to use at which budget."""

from __future__ import annotations

from harness.report.budget_table import budget_table, crossover_table
from harness.report.figure_files import FigureFiles
from harness.report.figures import plot_plane
from harness.report.knobs_table import knobs_table
from harness.report.material import Material
from harness.report.sections.section import Content, in_parts, those
from harness.report.trade_figure import plot_trade


def trade(material: Material, figures: FigureFiles) -> Content | None:
    """Time against error, by scene: all ways to the picture of `path`."""
    trades = those(
        [
            figures.add(f"trade-{job.name}", plot_trade(material.measurements, job), job.title, "")
            for job in material.pictured
        ]
    )
    planes = in_parts(figures, "plane", plot_plane, material)
    return {"trades": trades, "planes": planes} if trades or planes else None


def budget(material: Material, figures: FigureFiles) -> Content | None:
    """At this budget use that; until when a shortcut pays; what a knob costs."""
    del figures
    table = budget_table(material.measurements, material.pictured)
    if table is None:
        return None
    return {
        "budget": table,
        "crossover": crossover_table(material.measurements, material.pictured),
        "knobs": knobs_table(material.measurements, material.pictured),
    }
