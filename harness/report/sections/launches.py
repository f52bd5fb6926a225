"""Sections on schedules: packets, engines, and what a launch costs."""

from __future__ import annotations

from harness.report.figure_files import FigureFiles
from harness.report.figures import plot_packets
from harness.report.ladder import find_rungs, ladder_table, plot_ladder
from harness.report.material import Material
from harness.report.sections.section import Content, those
from harness.report.study import Variant, compared_sizes, find_variants, panels_of, timelines
from harness.report.study_figures import plot_ladder_bars, plot_throughput, plot_timeline
from harness.report.study_tables import law_table, memory_table, price_table, work_table
from harness.report.tables import packets_table


def packets(material: Material, figures: FigureFiles) -> Content | None:
    """Throughput of the paper's engine over the size of its packets."""
    panels = [(job.name, model) for job in material.jobs for model in job.models]
    figure = figures.add(
        "packets", plot_packets(material.measurements, panels), "Rates over packet sizes", ""
    )
    if figure is None:
        return None
    return {"packets": figure, "sweep": packets_table(material.measurements, material.jobs)}


def engines(material: Material, figures: FigureFiles) -> Content | None:
    """The same rays in every schedule."""
    rungs = find_rungs(material.measurements, material.jobs)
    figure = figures.add("engines", plot_ladder(rungs), "Rates of the engines", "")
    return None if figure is None else {"ladder": figure, "engines": ladder_table(rungs)}


def launches(material: Material, figures: FigureFiles) -> Content | None:
    """The study of packets: the law of a launch, its price, what waits, where the time goes."""
    rows = material.measurements
    variants, sizes = find_variants(rows), compared_sizes(material.studies)
    work = work_table(rows, variants, sizes)
    if work is None:
        return None
    return {
        "study_figures": _study_figures(material, figures, variants),
        "launch_laws": law_table(rows, variants),
        "launch_work": work,
        "queue_memory": memory_table(rows),
        "prices": price_table(rows, sizes),
    }


def _study_figures(
    material: Material, figures: FigureFiles, variants: list[Variant]
) -> list[object]:
    rows, captions = material.measurements, material.captions
    tracers = list(dict.fromkeys(one.tracer for one in variants))
    found = [
        figures.add(
            f"study-ladder-{tracer}",
            plot_ladder_bars(rows, variants, tracer),
            f"The ladder, {tracer}",
            captions["study_ladder"],
        )
        for tracer in tracers
    ]
    found += [
        figures.add(
            f"study-{scene}-{model}-{tracer}",
            plot_throughput(rows, variants, (scene, model), tracer),
            f"{scene}, {model}, {tracer}",
            captions["study_throughput"],
        )
        for scene, model in panels_of(variants)
        for tracer in tracers
    ]
    found += [
        figures.add(
            f"study-timeline-{job.name}-{job.model}",
            plot_timeline(timelines(job), f"{job.name}, {job.model}"),
            f"Copies and kernels, {job.name}, {job.model}",
            captions["study_timeline"],
        )
        for job in material.studies
        if job.model in job.provenance["config"]["study"]["panels"].get(job.name, [])
    ]
    return list(those(found))
