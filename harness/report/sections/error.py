"""Sections on error: how it falls, at which scale of the image it lies, how single images vary."""

from __future__ import annotations

from harness.report.figure_files import FigureFiles
from harness.report.figures import plot_convergence
from harness.report.material import Material
from harness.report.quantiles_figure import plot_quantiles
from harness.report.sections.section import Content, in_parts
from harness.report.spectrum_figure import find_spectra, plot_spectra, spectrum_table
from harness.report.tables import error_table


def convergence(material: Material, figures: FigureFiles) -> Content:
    """Error against samples a pixel, with the truth's noise as the floor."""
    return {
        "convergence": in_parts(figures, "convergence", plot_convergence, material),
        "errors": error_table(material.measurements, material.pictured),
    }


def spectrum(material: Material, figures: FigureFiles) -> Content | None:
    """At which scale of the image the error lies."""
    found = find_spectra(material.measurements, [job.name for job in material.pictured])
    figure = figures.add("spectrum", plot_spectra(found), "Error spectrum ensembles", "")
    if figure is None:
        return None
    return {"spectrum": figure, "spectra": spectrum_table(found)}


def quantiles(material: Material, figures: FigureFiles) -> Content | None:
    """How much the error of one image varies from seed to seed."""
    # Where the radiance is known to be the same all over, an image may have no error at all.
    scenes = [job.name for job in material.pictured]
    figure = figures.add(
        "quantiles", plot_quantiles(material.measurements, scenes), "Error of single images", ""
    )
    return None if figure is None else {"quantiles": figure}
