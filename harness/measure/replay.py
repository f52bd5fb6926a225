"""One class of rays through one tracer, in the process of the tracer."""

import resource
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from harness.measure.counters import NvmlError, read_energy
from harness.measure.messages import Replay, Replayed, Take
from harness.rays.agreement import evenly
from harness.rays.store import read_rays
from harness.tracers.base import Tracer
from harness.tracers.rays import Held, Query, Rays, make_rays


@dataclass(frozen=True, slots=True)
class _Class:
    """One class of rays of a file, and the shares of it that a tracer holds."""

    rays: Rays
    held: dict[int, Held] = field(default_factory=dict)

    def share(self, tracer: Tracer, most: int | None) -> Held:
        """All rays, or `most` of them, in the memory of the tracer that this process is of."""
        count = min(most or len(self.rays), len(self.rays))
        if count not in self.held:
            self.held[count] = tracer.hold(self._some(count))
        return self.held[count]

    def _some(self, count: int) -> Rays:
        if count == len(self.rays):
            return self.rays
        places = evenly(len(self.rays), count)
        return Rays(*(getattr(self.rays, part)[places] for part in Rays.__slots__))


@lru_cache(maxsize=1)
def _class_of(file: Path, name: str) -> _Class:
    """Rays of a file, kept for the repeats: every class is replayed for a while."""
    rays = read_rays(file, name)
    return _Class(make_rays(rays.origins, rays.directions, rays.t_min, rays.t_max))


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


def take(tracer: Tracer, request: Take) -> None:
    """Read a class of rays and have the tracer hold it, so that no replay need wait for that."""
    one = _class_of(request.file, request.rays)
    for most in request.most:
        one.share(tracer, most)


def replay(tracer: Tracer, request: Replay) -> Replayed:
    """Answer a request; raises UnsupportedError where the tracer has no such query or way."""
    rays = _class_of(request.file, request.rays).share(tracer, request.most)
    query = Query(request.any_hit, request.repeats, count=request.hits, hits=request.hits)
    before = _energy() if request.energy else "not asked for"
    hits = tracer.replay(rays, request.way, query)
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
