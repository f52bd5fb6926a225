"""Where every number of a run comes from: provenance.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from harness.tables.read import run_name

Provenance = Mapping[str, Any]


def merge_provenance(
    scenes: Mapping[str, Provenance], parts: Mapping[str, Mapping[str, Provenance]] | None = None
) -> dict[str, Any]:
    """Join the provenance of a run's jobs: what the scenes share once, what differs by job.

    Parameters
    ----------
    scenes
        Provenance of the jobs of images by scene, at least one.
    parts
        Provenance of every other job by its part of the run (`rays`, `features`, `study`, ...) and
        its name. What the scenes share is left out of it; each has a machine and a command of its
        own, for a run may be put together from parts that several machines have measured.
    """
    first, *rest = scenes.values()
    shared = {k: v for k, v in first.items() if all(k in one and one[k] == v for one in rest)}
    merged: dict[str, Any] = {"run": run_name(first), **shared}
    for part, jobs in {"scenes": scenes, **(parts or {})}.items():
        merged[part] = {
            name: {k: v for k, v in one.items() if k not in shared or shared[k] != v}
            for name, one in jobs.items()
        }
    return merged
