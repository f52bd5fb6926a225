"""Haines's eye rays: how many of an image's rays hit anything, beside the published count.

The Standard Procedural Databases give for each scene the number of rays that hit something when one
is sent through every corner of a pixel (E. Haines, A proposal for standard graphics environments,
IEEE Computer Graphics and Applications 7(11), 1987). The count needs no shading, so it judges
geometry, camera and traversal alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.scene import Camera
from harness.tracers.rays import NONE

ALLOWED_PPM = 50.0
"""Share of the rays, per million, on which two tracers may see different things.

A ray that grazes a silhouette or passes through a shared edge may be decided either way by
arithmetic that rounds differently; a lost primitive or a moved camera costs thousands per million.
"""

SAME_DISTANCE = 2.0**-10
"""Relative difference of two distances below which two primitives are neighbours in one surface."""


def corner_rays(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Rays through the corners of a camera's pixels, x = 0 .. width, y = 0 .. height.

    Returns
    -------
    origins, directions
        float32 [(height + 1) * (width + 1), 3], row by row. Rays start on the near plane, as those
        of images do; directions have unit length before they are rounded.
    """
    x, y = np.meshgrid(np.arange(camera.width + 1.0), np.arange(camera.height + 1.0))
    direction = (
        np.array(camera.corner)
        + x[..., None] * np.array(camera.dx)
        + y[..., None] * np.array(camera.dy)
    ).reshape(-1, 3)
    origin = np.array(camera.origin) + camera.near * direction
    unit = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return origin.astype(np.float32), unit.astype(np.float32)


@dataclass(frozen=True, slots=True)
class Seen:
    """What one tracer sees: t [N], infinity without a hit, and primitive uint32 [N]."""

    t: NDArray[np.floating]
    primitive: NDArray[np.uint32]

    @property
    def hits(self) -> int:
        """Number of rays that hit something."""
        return int(np.isfinite(self.t).sum())


def count_differences(a: Seen, b: Seen) -> int:
    """Count the rays on which two tracers differ.

    They differ where one hits and the other does not, and where they hit different primitives at
    distances that are further apart than `SAME_DISTANCE`: on a shared edge either side is right.
    """
    hit_a, hit_b = np.isfinite(a.t), np.isfinite(b.t)
    other = (a.primitive != b.primitive) | (a.primitive == NONE)
    # Few of millions: distances need be compared where primitives differ only.
    doubtful = np.flatnonzero(hit_a & hit_b & other)
    t_a, t_b = a.t[doubtful].astype(np.float64), b.t[doubtful].astype(np.float64)
    apart = np.abs(t_a - t_b) > SAME_DISTANCE * np.maximum(t_a, t_b)
    return int(np.count_nonzero(hit_a != hit_b) + np.count_nonzero(apart))


@dataclass(frozen=True, slots=True)
class EyeRayVerdict:
    """What is said of one tracer on one scene."""

    scene: str
    tracer: str
    hits: int
    rays: int
    published: int
    share: float
    """by how much of it the count may be off"""
    disagreeing: int
    """rays on which it differs from the reference in double precision"""
    differing: Mapping[str, int]
    """rays on which it differs from another tracer, by name"""

    def ppm(self, count: int) -> float:
        """A number of rays per million."""
        return 1e6 * count / self.rays

    @property
    def excess(self) -> float:
        """Relative difference to the published count."""
        return self.hits / self.published - 1.0 if self.published else float(self.hits > 0)

    @property
    def counted(self) -> bool:
        """Whether the count is the published one within its share."""
        return abs(self.hits - self.published) <= self.share * self.published

    @property
    def agrees(self) -> bool:
        """Whether it sees what double precision and every other tracer see."""
        counts = (self.disagreeing, *self.differing.values())
        return all(self.ppm(count) <= ALLOWED_PPM for count in counts)

    @property
    def passed(self) -> bool:
        """Both."""
        return self.counted and self.agrees

    def describe(self) -> str:
        """One line for the terminal."""
        verdict = "PASS" if self.passed else "FAIL"
        apart = max(self.differing.items(), key=lambda item: item[1], default=("", 0))
        text = (
            f"{self.hits:,} of {self.rays:,} rays hit, {self.excess:+.2%} of the published "
            f"{self.published:,}, within ±{self.share:.0%}: {'PASS' if self.counted else 'FAIL'}; "
            f"{self.ppm(self.disagreeing):.1f} ppm differ from double precision"
        )
        if apart[0]:
            text += f", {self.ppm(apart[1]):.1f} ppm from {apart[0]}"
        text += f", at most {ALLOWED_PPM:g}: {'PASS' if self.agrees else 'FAIL'}"
        return f"{verdict:<18} {f'{self.scene} eye rays {self.tracer}':<40} {text}"


@dataclass(frozen=True, slots=True)
class NoEyeRays:
    """A tracer that traced no eye rays, and why."""

    scene: str
    tracer: str
    status: str
    """skipped or failed"""
    reason: str

    @property
    def passed(self) -> bool:
        """Whether that is no fault of the tracer."""
        return self.status == "skipped"

    def describe(self) -> str:
        """One line for the terminal."""
        verdict = "skipped" if self.passed else "FAIL"
        return f"{verdict:<18} {f'{self.scene} eye rays {self.tracer}':<40} {self.reason}"


def judge_eye_rays(
    scene: str, record: Mapping[str, Any] | None
) -> Sequence[EyeRayVerdict | NoEyeRays]:
    """Judge every tracer of a scene by the record of `measure_eye_rays`; none without a record."""
    if record is None:
        return []
    return [
        EyeRayVerdict(
            scene=scene,
            tracer=name,
            hits=row["hits"],
            rays=record["rays"],
            published=record["published"],
            share=record["share"],
            disagreeing=row["disagreeing"],
            differing=row["differing"],
        )
        if row["status"] == "ok"
        else NoEyeRays(scene, name, row["status"], row["reason"])
        for name, row in ((name, record["tracers"][name]) for name in record["order"])
    ]
