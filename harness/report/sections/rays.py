"""Sections on rays for their own sake: the benchmark of rays, Haines's eye rays."""

from __future__ import annotations

from harness.report.eye_rays_table import eye_rays_table
from harness.report.figure_files import FigureFiles
from harness.report.material import Material
from harness.report.rays import (
    find_ray_rows,
    hierarchy_table,
    missing_table,
    optix_note,
    ratio_table,
    ray_table,
)
from harness.report.rays_figures import plot_ray_ratios, plot_ray_tests
from harness.report.sections.section import Content, those
from harness.tables.rays import RATIOS_TO


def rays(material: Material, figures: FigureFiles) -> Content | None:
    """The same rays through every tracer, by class."""
    rows = find_ray_rows(material.measurements)
    table = ray_table(rows)
    if table is None:
        return None
    optix = optix_note(material.ray_jobs)
    found = [
        figures.add(
            f"rays-{other}",
            plot_ray_ratios(rows, other),
            f"Rays a second over {other}",
            f"{material.captions['ray_ratios']} {optix}".strip(),
        )
        for other in RATIOS_TO
    ]
    primitives = {job.name: job.primitives for job in material.ray_jobs}
    caption = material.captions["ray_tests"]
    found.append(figures.add("ray-tests", plot_ray_tests(rows, primitives), "Tests a ray", caption))
    return {
        "rays": table,
        "optix": optix,
        "ray_figures": those(found),
        "ray_ratios": ratio_table(rows),
        "ray_hierarchies": hierarchy_table(rows),
        "rays_skipped": missing_table(rows),
    }


def eye_rays(material: Material, figures: FigureFiles) -> Content | None:
    """Counts of eye rays beside the published ones."""
    del figures
    table = eye_rays_table(material.jobs)
    return None if table is None else {"eye_rays": table}
