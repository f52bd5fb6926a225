"""Where every number of a run comes from: provenance.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from harness.tables.read import ResultsError, run_name

Provenance = Mapping[str, Any]
PARTS = ("rays", "stability", "modes", "surfaces", "sweeps", "features", "study")
"""Parts of a run beside the images of its scenes, as provenance.json names them."""


def records_of(provenance: Provenance) -> list[Provenance]:
    """What the jobs of a run share, and then what they do not, job by job, images first."""
    parts = [provenance.get(part, {}) for part in ("scenes", *PARTS)]
    return [provenance, *(one for part in parts for one in part.values())]


def machine_of(provenance: Provenance) -> Provenance:
    """The machine of a run: the one that its jobs share, else that of the first of them."""
    machines = (one["machine"] for one in records_of(provenance) if "machine" in one)
    return next(machines, {})


def commits_of(provenance: Provenance) -> list[str]:
    """Every commit that a part of the run was measured at, and whether it was changed."""
    return sorted(
        {
            str(one["commit"]) + (" with local changes" if one.get("dirty") else "")
            for one in ({**provenance, **record} for record in records_of(provenance))
            if one.get("commit")
        }
    )


def merge_provenance(
    scenes: Mapping[str, Provenance], parts: Mapping[str, Mapping[str, Provenance]] | None = None
) -> dict[str, Any]:
    """Join the provenance of a run's jobs: what the scenes share once, what differs by job.

    Without a scene it is what all other jobs share that stands once.

    Parameters
    ----------
    scenes
        Provenance of the jobs of images by scene.
    parts
        Provenance of every other job by its part of the run (`rays`, `features`, `study`, ...) and
        its name. What the scenes share is left out of it; each has a machine and a command of its
        own, for a run may be put together from parts that several machines have measured.

    Raises
    ------
    ResultsError
        There is no job at all.
    """
    others = [one for jobs in (parts or {}).values() for one in jobs.values()]
    found = [*scenes.values()] or others
    if not found:
        raise ResultsError("nothing has been measured: neither scenes nor any other part of a run")
    first, *rest = found
    shared = {k: v for k, v in first.items() if all(k in one and one[k] == v for one in rest)}
    merged: dict[str, Any] = {"run": run_name(first), **shared}
    for part, jobs in {"scenes": scenes, **(parts or {})}.items():
        merged[part] = {
            name: {k: v for k, v in one.items() if k not in shared or shared[k] != v}
            for name, one in jobs.items()
        }
    return merged
