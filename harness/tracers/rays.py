"""Rays for their own sake, and where they hit: the joint between tracers and benchmarks of rays."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

NONE = np.uint32(0xFFFFFFFF)
"""Index of a shape or primitive where there is none, or where it is not known."""


@dataclass(frozen=True, slots=True)
class Rays:
    """Rays with the interval (t_min, t_max] in which hits count. Made by `make_rays`.

    origins, directions: float32 [N, 3]; t_min, t_max: float32 [N], in units of the direction, which
    need not have unit length.
    """

    origins: NDArray[np.float32]
    directions: NDArray[np.float32]
    t_min: NDArray[np.float32]
    t_max: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.origins)


class Held(Protocol):
    """Rays as a tracer holds them, to be traced as often as one likes."""

    def __len__(self) -> int:
        """How many they are."""


@dataclass(frozen=True, slots=True)
class Query:
    """What is asked of rays.

    any_hit: only whether there is a hit, as of a shadow ray, not where the closest one is. repeats:
    how often they are traced. count: what the traversal looks at, in a repeat that is not timed.
    hits: what is hit, which is much to hand back.
    """

    any_hit: bool = False
    repeats: int = 1
    count: bool = False
    hits: bool = True


@dataclass(frozen=True, slots=True)
class Way:
    """One way of a tracer to trace rays: its traversal, and the arithmetic of that."""

    traversal: str
    """name in harness/schemas/keys.yaml; empty where the tracer is another's and has no choice"""
    precision: str


@dataclass(frozen=True, slots=True)
class Visits:
    """What a traversal looked at, means over the rays: nodes whose boxes and triangles that it
    tested.
    """

    nodes: float
    triangles: float


@dataclass(frozen=True, slots=True)
class Structure:
    """An acceleration structure: seconds of its build, bytes of its nodes and primitives."""

    build_seconds: float
    size: float


@dataclass(frozen=True, slots=True)
class RayHits:
    """What a tracer found, one entry a ray; no entries where hits were not asked for.

    Attributes
    ----------
    t
        float32 [N], distance of the closest hit in units of the direction, infinity without one.
        Where any hit was asked for: 0 where there is one, infinity where there is none.
    shape
        uint32 [N], index into `Scene.shapes`; `NONE` without a hit, or where any hit was asked for.
    primitive
        uint32 [N], triangles from 0 in the order of `Scene.triangles`, then spheres; `NONE` also
        where the tracer's own shape is not made of the triangles of the import (Mitsuba's disk).
    times
        Time of tracing alone, [s], one entry a repeat: rays and hits lie in the tracer's memory,
        its code is compiled (from the second call on). NaN where a call a ray would be timed.
    visits
        What was looked at, where it was asked for and can be counted.
    extras
        Further numbers, named with their units (``upload_seconds``).
    """

    t: NDArray[np.float32]
    shape: NDArray[np.uint32]
    primitive: NDArray[np.uint32]
    times: tuple[float, ...]
    visits: Visits | None = None
    extras: dict[str, float] = field(default_factory=dict)

    @property
    def seconds(self) -> float:
        """Time of the last repeat, [s]."""
        return self.times[-1]

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Whether each ray hits anything. bool [N]."""
        return np.isfinite(self.t)


def _points(name: str, array: object) -> NDArray[np.float32]:
    if (
        not isinstance(array, np.ndarray)
        or array.dtype != np.float32
        or array.ndim != 2
        or array.shape[1] != 3
    ):
        raise ValueError(f"{name} must be a float32 array of shape [n, 3], not {_described(array)}")
    return np.ascontiguousarray(array)


def _distances(name: str, value: object, count: int) -> NDArray[np.float32]:
    if isinstance(value, np.ndarray) and value.ndim:
        if value.dtype != np.float32 or value.shape != (count,):
            raise ValueError(
                f"{name} must be a number or a float32 array of shape [{count}], one entry a ray, "
                f"not {_described(value)}"
            )
        return np.ascontiguousarray(value)
    return np.full(count, value, np.float32)


def _described(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {list(value.shape)}"
    return type(value).__name__


def _all_three(parts: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows of which all parts are true: `all` would go through millions of them one by one."""
    return parts[:, 0] & parts[:, 1] & parts[:, 2]


def make_rays(
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    t_min: float | NDArray[np.float32] = 0.0,
    t_max: float | NDArray[np.float32] = np.inf,
) -> Rays:
    """Check rays, and give every one an interval.

    Raises
    ------
    ValueError
        An array has not the shape or type that `Rays` wants, an origin or direction is not finite,
        a direction is zero, or an interval is not one of distances. Names the array or the ray.
    """
    starts, towards = _points("origins", origins), _points("directions", directions)
    count = len(starts)
    if len(towards) != count:
        raise ValueError(f"there are {count} origins, but {len(towards)} directions")
    rays = Rays(
        starts, towards, _distances("t_min", t_min, count), _distances("t_max", t_max, count)
    )
    for bad, what in (
        (~_all_three(np.isfinite(starts)), "its origin is not finite"),
        (~_all_three(np.isfinite(towards)), "its direction is not finite"),
        (_all_three(towards == 0.0), "its direction is zero"),
        (~((rays.t_min >= 0.0) & np.isfinite(rays.t_min)), "t_min must be finite and not negative"),
        (~(rays.t_max >= rays.t_min), "t_max must not be below t_min"),
    ):
        if bad.any():
            raise ValueError(f"ray {int(np.argmax(bad))}: {what}")
    return rays
