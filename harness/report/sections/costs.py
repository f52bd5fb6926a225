"""Sections on what a tracer takes: time by parts, memory, energy."""

from __future__ import annotations

from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.resources_table import resources_table
from harness.report.sections.section import Content
from harness.report.speed_figure import plot_speed
from harness.report.summary import warn_of_load
from harness.report.tables import speed_table, times_table


def speed(material: Material, figures: FigureFiles) -> Content:
    """Samples and rays a second of whole renders."""
    scenes = [job.name for job in material.jobs]
    return {
        "speeds": figures.add(
            "speed", plot_speed(material.measurements, scenes), "Samples a second", ""
        ),
        "speed": speed_table(material.measurements, material.jobs),
        "warning": warn_of_load(material.jobs),
    }


def times(material: Material, figures: FigureFiles) -> Content:
    """What comes before the first ray, memory, energy."""
    del figures
    return {
        "times": times_table(material.measurements, material.jobs),
        "resources": resources_table(material.measurements),
    }
