"""The section on what a feature costs that a scene does not use."""

from __future__ import annotations

from harness.report.features import find_prices, plot_prices, price_list, priced_models
from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.sections.section import Content, those


def features(material: Material, figures: FigureFiles) -> Content | None:
    """Kernels with more features than a scene requires, in time and registers."""
    prices = find_prices(material.measurements)
    table = price_list(prices)
    if table is None:
        return None
    found = [
        figures.add(f"features-{model}", plot_prices(prices, model), f"Features, {model}", "")
        for model in priced_models(prices)
    ]
    return {"feature_prices": table, "feature_figures": those(found)}
