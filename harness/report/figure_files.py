"""Figures as files of their own and as parts of the page."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from jinja2 import Template
from matplotlib.figure import Figure

from harness.report.style import BAND, FAINT, GRID, INK, colour_of, save_svg

VARIABLES = {
    INK: "--ink",
    FAINT: "--faint",
    GRID: "--grid",
    BAND: "--band",
    "#ffffff": "--figure",
    "#0072b2": "--blue",
}
"""Colours of a figure that follow the page's. Of the tracers' only the blue is too dark for a dark
page."""

STYLE_SHEET = '<style type="text/css">*{stroke-linejoin: round; stroke-linecap: butt}</style>'
"""Of every SVG file that matplotlib writes."""


@dataclass(frozen=True, slots=True)
class Embedded:
    """A figure inside the page."""

    name: str
    """of its file, without the ending"""
    title: str
    svg: str
    caption: str
    on_paper: bool
    """whether its colours are a white page's, as those of a map of numbers"""


def colour_in_page(tracer: str) -> str:
    """Colour of a tracer in the page, the same as in the figures within it."""
    colour = colour_of(tracer)
    variable = VARIABLES.get(colour.lower())
    return f"var({variable})" if variable else colour


def embed(svg: str, prefix: str) -> str:
    """Make an SVG file part of a page.

    It loses its prologue; its style sheet, whose one rule is the page's (`.card svg`), and which
    would have the browser style all of the page once more; ids that nothing
    refers to, or that another figure may have too; and the colours that belong to paper.
    """
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>\s*", "", body, flags=re.DOTALL)
    body = body.replace(STYLE_SHEET, "")
    referred = set(re.findall(r'url\(#([^)]+)\)|href="#([^"]+)"', body))
    kept = {name for pair in referred for name in pair}

    def own_id(found: re.Match[str]) -> str:
        return f' id="{prefix}-{found[1]}"' if found[1] in kept else ""

    body = re.sub(r'\sid="([^"]+)"', own_id, body)
    body = re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", body)
    body = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', body)
    for colour, variable in VARIABLES.items():
        body = re.sub(rf"(fill|stroke): {colour}\b", rf"\1: var({variable})", body)
    return body


@dataclass
class FigureFiles:
    """Writer of a report's figures, which knows those that it has written."""

    folder: Path
    what_to_see: str
    """template of a caption, which takes the figure's name as Snakemake gives it"""
    names: list[str] = field(default_factory=list)

    def add(self, name: str, figure: Figure | None, title: str, caption: str) -> Embedded | None:
        """Write a figure, and return it for the page; None stays None."""
        if figure is None:
            return None
        path = self.folder / f"{name}.svg"
        save_svg(figure, path)
        self.names.append(path.name)
        svg = embed(path.read_text(), name)
        label = title.replace("&", "&amp;").replace('"', "&quot;")
        svg = svg.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
        wildcards = {"wildcards": {"figure": name}}
        see = Template(self.what_to_see).render(snakemake=wildcards).strip()
        return Embedded(name, title, svg, f"{caption} {see}".strip(), "<image" in svg)
