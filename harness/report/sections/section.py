"""What a section of the report is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from harness.report.figure_files import Embedded, FigureFiles
from harness.report.figures import MOST_PANELS, Panel, converging_panels
from harness.report.material import Material
from harness.tables.lookup import Measurements

Content = Mapping[str, Any]
"""What a section's template is given, by name; names are unique within the page."""


@dataclass(frozen=True, slots=True)
class Section:
    """A part of the page: one template, and the function that makes what it shows."""

    name: str
    """id of the element, and name of the template"""
    title: str
    """in the navigation"""
    make: Callable[[Material, FigureFiles], Content | None]
    """None where the run measured nothing of the kind: then there is no such section"""
    of_images: bool = False
    """whether a run without images has no such section"""

    @property
    def template(self) -> str:
        """File name of the template."""
        return f"{self.name}.html.j2"


def in_parts(
    figures: FigureFiles,
    name: str,
    plot: Callable[[Measurements, Sequence[Panel]], Figure | None],
    material: Material,
) -> list[Embedded]:
    """Figures of every scene and model with images at several sample counts, MOST_PANELS each."""
    every = [(job.name, model) for job in material.jobs for model in job.models]
    panels = converging_panels(material.measurements, every)
    parts = [panels[k : k + MOST_PANELS] for k in range(0, len(panels), MOST_PANELS)]
    return those(
        [
            figures.add(
                f"{name}-{number}",
                plot(material.measurements, part),
                ", ".join(dict.fromkeys(scene for scene, _ in part)),
                "",
            )
            for number, part in enumerate(parts, start=1)
        ]
    )


def those(figures: list[Embedded | None]) -> list[Embedded]:
    """The figures that there are."""
    return [figure for figure in figures if figure is not None]
