"""One class of rays through one tracer, in the process of the tracer."""

import resource
from functools import lru_cache
from pathlib import Path

import numpy as np

from harness.measure.counters import NvmlError, read_energy
from harness.measure.messages import Replay, Replayed
from harness.rays.agreement import evenly
from harness.rays.store import read_rays
from harness.tracers.base import Tracer
from harness.tracers.rays import Rays


@lru_cache(maxsize=1)
def _rays_of(file: Path, name: str, most: int | None) -> Rays:
    """Rays of a file, kept for the repeats: every class is replayed for a while."""
    rays = read_rays(file, name)
    if most is None or most >= len(rays):
        return rays
    place = evenly(len(rays), most)
    return Rays(*(np.ascontiguousarray(getattr(rays, part)[place]) for part in Rays.__slots__))


def _energy() -> float | str:
    """The GPU's counter, [J], or why it is not told."""
    try:
        return read_energy()
    except NvmlError as error:
        return str(error)


def _joules(before: float | str, after: float | str, repeats: int) -> float | str:
    if isinstance(before, str):
        return before
    return after if isinstance(after, str) else (after - before) / repeats


def replay(tracer: Tracer, request: Replay) -> Replayed:
    """Answer a request; raises UnsupportedError where the tracer has no such query or way."""
    rays = _rays_of(request.file, request.rays, request.most)
    before = _energy() if request.energy else "not asked for"
    hits = tracer.trace(
        *(rays.origins, rays.directions, rays.t_min, rays.t_max),
        any_hit=request.any_hit,
        way=request.way,
        repeats=request.repeats,
        count=request.hits,
    )
    after = _energy() if request.energy else "not asked for"
    return Replayed(
        times=hits.times,
        rays=len(rays),
        t=hits.t if request.hits else None,
        primitive=hits.primitive if request.hits else None,
        visits=hits.visits,
        structure=tracer.structure(request.way) if request.hits else None,
        peak_bytes=1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
        joules=_joules(before, after, request.repeats),
    )
