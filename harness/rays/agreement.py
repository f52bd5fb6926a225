"""How many rays two tracers, or a tracer and double precision, see differently."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.eye_rays import Seen, count_differences


@dataclass(frozen=True, slots=True)
class Share:
    """Some of the rays that were judged."""

    count: int
    rays: int

    @property
    def ppm(self) -> float:
        """Rays per million; NaN where none was judged."""
        return 1e6 * self.count / self.rays if self.rays else float("nan")


def compare(
    a: Seen, b: Seen, *, any_hit: bool, judged: NDArray[np.bool_] | None = None
) -> Share:
    """Count the rays on which two sights of the same rays differ.

    Where any hit was asked for they differ by having one or none; else as `count_differences` says.
    `judged` leaves the other rays out.
    """
    if judged is not None:
        a, b = (Seen(one.t[judged], one.primitive[judged]) for one in (a, b))
    if any_hit:
        return Share(int((np.isfinite(a.t) != np.isfinite(b.t)).sum()), len(a.t))
    return Share(count_differences(a, b), len(a.t))


def evenly(count: int, wanted: int) -> NDArray[np.int64]:
    """Places of `wanted` of `count` rays, at even distances; all of them where there are fewer."""
    wanted = min(count, wanted)
    return np.arange(wanted) * count // max(wanted, 1)
