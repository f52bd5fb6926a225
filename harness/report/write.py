"""Writer of the report: report.html, report.zip, figures/*.svg and tables/*.csv."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from harness.report.again import commands_of
from harness.report.bundle import write_bundle
from harness.report.figure_files import FigureFiles, colour_in_page
from harness.report.material import Material, read_material
from harness.report.sections import SECTIONS
from harness.report.sections.section import Section
from harness.report.tables import Table
from harness.tables.read import section_of_run
from harness.whole_files import write_whole, written_whole

HERE = Path(__file__).resolve().parent
TEMPLATES = HERE / "templates"
VIEWER = HERE.parent / "viewer"
OPEN_ROWS = 24
"""Rows of a table that the page shows unasked."""


def make_content(material: Material, figures: FigureFiles) -> tuple[list[Section], dict[str, Any]]:
    """What every section shows, by name, and the sections that have something to show."""
    content: dict[str, Any] = {}
    present = []
    for section in SECTIONS:
        if section.of_images and not material.jobs:
            continue
        made = section.make(material, figures)
        if made is None:
            continue
        twice = content.keys() & made.keys()
        if twice:
            raise ValueError(f"section {section.name}: {', '.join(sorted(twice))} is taken")
        content |= made
        present.append(section)
    return present, content


def write_csv(folder: Path, table: Table, commands: list[str]) -> None:
    """Write a table with all its columns, and the command of each row where a row is one row."""
    frame = table.frame
    if len(frame) == len(commands):
        frame = frame.assign(command=commands)
    with written_whole(folder / f"{table.name}.csv") as (path,):
        frame.to_csv(path, index=False, float_format="%.9g", lineterminator="\n")


def render(sections: list[Section], content: Mapping[str, Any], **more: Any) -> str:
    """The page. It refers to files beside it in links only; all that it shows is in it."""
    environment = Environment(
        loader=FileSystemLoader([TEMPLATES, VIEWER]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html.j2").render(
        sections=sections,
        css=(TEMPLATES / "page.css").read_text(),
        script=(TEMPLATES / "page.js").read_text(),
        colour=colour_in_page,
        open_rows=OPEN_ROWS,
        **content,
        **more,
    )


def write_report(results_dir: Path, baseline: Path | None = None) -> Path:
    """Write report.html with its figures and tables beside it, and report.zip; returns its path.

    Reads measurements.csv, which the tables' writer must have written before, and the images of the
    scene jobs. The page needs no other file; links lead to the files beside it. report.zip holds
    the same page with every image at full size. baseline: as of `read_material`. Raises
    ResultsError for missing or damaged files.
    """
    material = read_material(results_dir, baseline)
    provenance = material.provenance
    figures = FigureFiles(results_dir / "figures", material.captions["figure"])
    sections, content = make_content(material, figures)
    tables = [value for value in content.values() if isinstance(value, Table)]
    # Parts of a run may have been measured with settings that differ; these are the run's own.
    settings = section_of_run(results_dir) or provenance.get("config", {})
    of_run = {**provenance, "config": settings}
    again = {table.name: commands_of(table, of_run) for table in tables}
    for table in tables:
        write_csv(results_dir / "tables", table, again[table.name])
    shared = {
        "title": "Haste: what speed costs in accuracy",
        "subtitle": f"Ray tracers against a ground truth. Run “{provenance['run']}”.",
        "captions": material.captions,
        "again": again,
        "tables": [table.name for table in tables],
        "footer": "Made by Haste from measurements.csv and the images of the run.",
    }
    path = results_dir / "report.html"
    page = render(sections, content, zipped=False, images=[], **shared)
    write_whole(path, page)

    def page_of_bundle(viewer: Mapping[str, Any], images: list[Any]) -> str:
        return render(sections, {**content, "viewer": viewer}, zipped=True, images=images, **shared)

    files = [results_dir / name for name, _ in content["files"]]
    files += [results_dir / "figures" / name for name in figures.names]
    files += [results_dir / "tables" / f"{table.name}.csv" for table in tables]
    write_bundle(results_dir, files, page_of_bundle)
    return path
