"""What a section of the report is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from harness.report.figure_files import Embedded, FigureFiles
from harness.report.material import Material

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

    @property
    def template(self) -> str:
        """File name of the template."""
        return f"{self.name}.html.j2"


def those(figures: list[Embedded | None]) -> list[Embedded]:
    """The figures that there are."""
    return [figure for figure in figures if figure is not None]
