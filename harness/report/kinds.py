"""Names of figures: what they are about, for Snakemake's own report, and which are published."""

from __future__ import annotations

from typing import Any

CATEGORIES = {
    "trade": "What speed costs",
    "plane": "What speed costs",
    "convergence": "Error",
    "spectrum": "Error",
    "quantiles": "Error",
    "agreement": "Agreement",
    "answers": "Agreement",
    "packets": "Schedules",
    "engines": "Schedules",
    "study": "Schedules",
    "speed": "Speed",
    "cracks": "Stability",
    "stability": "Stability",
    "features": "Features",
    "rays": "Rays",
    "ray": "Rays",
}

PUBLISHED_FIGURES = (
    "published-speed",
    "published-planes",
    "published-trade",
    "published-packets",
    "published-rays",
    "published-features",
)
"""Files of docs/images, without their ending; harness/report/published.py says what each shows."""


def category_of(figure: str) -> str:
    """Category of a figure by the first word of its name."""
    return CATEGORIES.get(figure.partition("-")[0], "Figures")


def figure_category(wildcards: Any) -> str:
    """The same for Snakemake, which names the figure as a wildcard."""
    return category_of(wildcards.figure)
