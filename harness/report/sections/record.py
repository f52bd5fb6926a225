"""Sections on where a report comes from: provenance, files, formulas, commands."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import yaml

from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.sections.section import Content
from harness.report.summary import collect_facts, reproduce

QUANTITIES = Path(__file__).resolve().parents[2] / "schemas" / "quantities.yaml"


@cache
def quantities() -> list[tuple[str, str, str]]:
    """Name, unit and meaning of every quantity, in the order of the closed list."""
    listed = yaml.safe_load(QUANTITIES.read_text())
    return [(name, row["unit"], " ".join(row["meaning"].split())) for name, row in listed.items()]


def provenance(material: Material, figures: FigureFiles) -> Content:
    """Machine, versions, settings."""
    del figures
    return {
        "facts": collect_facts(material.provenance, material.jobs),
        "provenance": json.dumps(material.provenance, indent=1, sort_keys=True),
    }


def downloads(material: Material, figures: FigureFiles) -> Content:
    """Every file that belongs to the report."""
    files = [
        ("measurements.csv", "every measured quantity with its 95 % interval, one a row"),
        ("samples.parquet", "every seed and repeat, one a row"),
        ("provenance.json", "machine, versions, flags, settings, seeds, hashes"),
        ("settings.json", "the settings of the run, as Snakemake read them"),
        ("features.txt", "what each scene requires of a tracer"),
    ]
    return {
        "files": [(name, what) for name, what in files if (material.folder / name).is_file()],
        "figure_names": list(figures.names),
    }


def formulas(material: Material, figures: FigureFiles) -> Content:
    """What the numbers mean, exactly."""
    del figures
    measured = {row.quantity for row in material.measurements.rows if row.status == "ok"}
    return {"quantities": [row for row in quantities() if row[0] in measured]}


def commands(material: Material, figures: FigureFiles) -> Content:
    """How to make all of it again."""
    del figures
    return {"commands": reproduce(material.provenance, material.jobs)}
