"""Equal films: what tracers promise bit for bit, over engines, packet sizes, orders and repeats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from harness.tables.read import SceneJob
from harness.tables.study import StudyJob


def groups_of(job: SceneJob | StudyJob) -> Sequence[Mapping[str, Any]]:
    """The renders of one tracer, model, seed and sample count: how many, and how many films."""
    return job.description.get("films", [])


def describe_films(jobs: Sequence[SceneJob | StudyJob]) -> list[str]:
    """One line for each group whose films differ, and one for all; none if nothing promises."""
    groups = [(job.name, row) for job in jobs for row in groups_of(job)]
    if not groups:
        return []
    lines = [
        f"{'FAIL':<18} {scene + ' ' + row['model'] + ' ' + row['tracer']:<40} "
        f"{row['different_films']} films of seed {row['seed']} with {row['spp']} samples a pixel, "
        f"by {', '.join(row['engines'])}"
        for scene, row in groups
        if row["different_films"] > 1
    ]
    engines = {engine for _, row in groups for engine in row["engines"]}
    renders = sum(row["renders"] for _, row in groups)
    lines.append(
        f"films: {renders} renders in {len(groups)} groups of one seed, over "
        f"{len(engines)} engines ({', '.join(sorted(engines))}); "
        f"{len(lines)} groups with films that differ"
    )
    return lines


def films_exit_code(jobs: Sequence[SceneJob | StudyJob]) -> int:
    """0 if no group has two films, 1 otherwise."""
    return int(any(row["different_films"] > 1 for job in jobs for row in groups_of(job)))
