"""How many rays two tracers, or a tracer and double precision, see differently."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from harness.eye_rays import Seen, count_differences

LONGEST_RUN = 64
"""Neighbouring rays that are taken together: as many as two warps of a GPU trace."""

LEAST_RUNS = 4096
"""Runs that a share consists of, before they are longer than one ray."""


@dataclass(frozen=True, slots=True)
class Share:
    """Some of the rays that were judged."""

    count: int
    rays: int

    @property
    def ppm(self) -> float:
        """Rays per million; NaN where none was judged."""
        return 1e6 * self.count / self.rays if self.rays else float("nan")


def compare(a: Seen, b: Seen, *, any_hit: bool) -> Share:
    """Count the rays on which two sights of the same rays differ.

    Where any hit was asked for they differ by having one or none; else as `count_differences` says.
    """
    if any_hit:
        return Share(int(np.count_nonzero(np.isfinite(a.t) != np.isfinite(b.t))), len(a.t))
    return Share(count_differences(a, b), len(a.t))


@lru_cache(maxsize=8)
def evenly(count: int, wanted: int) -> NDArray[np.int64]:
    """Places of `wanted` of `count` rays from all over them; all of them where there are fewer.

    They rise, and are not to be written to: equal shares are one array.

    A large share comes in runs of up to `LONGEST_RUN` neighbours, which are as coherent as all of
    them are. Of counts that are powers of two the smaller is part of the larger.
    """
    if wanted >= count:
        places = np.arange(count)
    else:
        run = min(LONGEST_RUN, max(1, wanted // LEAST_RUNS))
        runs = -(-wanted // run)
        starts = np.arange(runs) * count // runs
        places = (starts[:, None] + np.arange(run)).ravel()[:wanted]
    places.setflags(write=False)
    return places


@dataclass(frozen=True, slots=True)
class Sight:
    """What a tracer saw of some of the rays of a class: their places in the file, rising."""

    places: NDArray[np.int64]
    seen: Seen

    @property
    def _all(self) -> bool:
        """Whether no ray is left out before the last: then none need be searched for."""
        return len(self.places) > 0 and int(self.places[-1]) == len(self.places) - 1

    def both(self, other: "Sight") -> tuple[Seen, Seen]:
        """What this and another saw of the rays that both have traced."""
        if self.places is other.places or np.array_equal(self.places, other.places):
            return self.seen, other.seen
        if len(self.places) < len(other.places):
            theirs, own = other.both(self)
            return own, theirs
        at = other.places if self._all else np.searchsorted(self.places, other.places)
        at = at.clip(max=len(self.places) - 1)
        common = np.flatnonzero(self.places[at] == other.places)
        return _part(self.seen, at[common]), _part(other.seen, common)


def _part(seen: Seen, places: NDArray[np.integer]) -> Seen:
    return Seen(seen.t[places], seen.primitive[places])
