"""Sections on how a run came out: the strip, pictures, agreement, known answers."""

from __future__ import annotations

from harness.report.agreement_figure import plot_agreement
from harness.report.answers_figure import plot_answers
from harness.report.answers_table import answers_table
from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.sections.section import Content
from harness.report.strip import make_strip
from harness.report.summary import explain_gate, summarise
from harness.report.tables import absence_table, verdict_table
from harness.report.thumbnails import make_thumbnail


def strip(material: Material, figures: FigureFiles) -> Content:
    """Verdicts of every scene and tracer, and the small pictures of the scenes below them."""
    del figures
    found = make_strip(material)
    tallies = {
        row.scene: [
            (sign, kind, count)
            for sign, kind, _, _ in found.counts
            if kind != "none" and (count := sum(mark.kind == kind for mark in row.marks))
        ]
        for row in found.rows
    }
    thumbnails = [make_thumbnail(job, tallies[job.name]) for job in material.pictured]
    return {
        "strip": found,
        "thumbnails": [one for one in thumbnails if one is not None],
        "summary": summarise(
            material.jobs, material.judgements, material.absent, material.measurements
        ),
    }


def agreement(material: Material, figures: FigureFiles) -> Content:
    """What the gate found, question by question."""
    return {
        "question": explain_gate(material.settings, material.judgements),
        "agreement": figures.add(
            "agreement",
            plot_agreement(material.judgements),
            "Relative bias of every tracer on every scene",
            material.captions["agreement"],
        ),
        "verdicts": verdict_table(material.judgements),
        "skipped": absence_table(material.absent, material.jobs),
    }


def answers(material: Material, figures: FigureFiles) -> Content | None:
    """Scenes whose radiance is known."""
    table = answers_table(material.answers)
    if table is None:
        return None
    return {
        "answers": table,
        "answers_figure": figures.add(
            "answers",
            plot_answers(material.answers),
            "Error where the radiance is known",
            material.captions["answers"],
        ),
    }
