"""The paper's models once more, in float64 numpy, for scenes of spheres and horizontal squares.

Written from docs/lighting.md for the tests alone: every child is traced, the intersections are
formulas, and `Reading` plants known mistakes, so that a test shows it would have seen them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rgb = tuple[float, float, float]
BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Material:
    diffuse: Rgb = BLACK
    specular: Rgb = BLACK
    ambient: Rgb = BLACK
    exponent: float = 30.0
    reflection: float = 0.0
    transmission: float = 0.0
    ior: float = 1.5
    dielectric: bool = False

    def mitsuba(self) -> dict[str, Any]:
        if self.dielectric:
            return {"type": "dielectric", "int_ior": self.ior, "ext_ior": 1.0}
        colours = {"diffuse": self.diffuse, "specular": self.specular, "ambient": self.ambient}
        return {
            "type": "phong",
            **{f"{name}_reflectance": colour(value) for name, value in colours.items()},
            "exponent": self.exponent,
            "reflection": self.reflection,
            "transmission": self.transmission,
            "int_ior": self.ior,
        }


@dataclass(frozen=True)
class Body:
    """A sphere of radius `size`, or a square of half-width `size` in a plane of constant z."""

    kind: str
    centre: Rgb
    size: float
    material: Material = field(default_factory=Material)
    radiance: Rgb = BLACK

    def mitsuba(self) -> dict[str, Any]:
        import mitsuba as mi

        place = mi.ScalarTransform4f().translate(list(self.centre)).scale(self.size)
        shape = {
            "type": "sphere" if self.kind == "sphere" else "rectangle",
            "to_world": place,
            "bsdf": self.material.mitsuba(),
        }
        if any(self.radiance):
            shape["emitter"] = {"type": "area", "radiance": colour(self.radiance)}
        return shape

    def distances(self, o: Array, d: Array) -> Array:
        """Distance to the first hit beyond a rounding error, infinite without one."""
        offset = o - np.asarray(self.centre)
        if self.kind == "square":
            with np.errstate(divide="ignore", invalid="ignore"):
                t = -offset[:, 2] / d[:, 2]
                x, y = offset[:, 0] + t * d[:, 0], offset[:, 1] + t * d[:, 1]
            good = (t > 1e-9) & (np.abs(x) <= self.size) & (np.abs(y) <= self.size)
            return np.where(good, t, np.inf)
        b = dot(offset, d)
        discriminant = b * b - dot(offset, offset) + self.size**2
        root = np.sqrt(np.maximum(discriminant, 0.0))
        near, far = -b - root, -b + root
        t = np.where(near > 1e-9, near, far)
        return np.where((discriminant > 0.0) & (t > 1e-9), t, np.inf)

    def normals(self, p: Array) -> Array:
        if self.kind == "square":
            return np.tile([0.0, 0.0, 1.0], (len(p), 1))
        return unit(p - np.asarray(self.centre))


@dataclass(frozen=True)
class Reading:
    """Mistakes to plant; the defaults are docs/lighting.md."""

    ambient_is_cosine_weighted: bool = False
    lights_are_sampled_on_the_surface: bool = False
    light_passes_through_glass: bool = False
    total_reflection_feeds_the_mirror: bool = False
    ambient_sees_emission: bool = False
    fronts_only: bool = False


def colour(value: Rgb) -> dict[str, Any]:
    return {"type": "rgb", "value": list(value)}


def dot(a: Array, b: Array) -> Array:
    return np.einsum("ij,ij->i", a, b)


def unit(v: Array) -> Array:
    return v / np.sqrt(dot(v, v))[:, None]


class Model:
    """`haste`, or `whitted` where `ambient` is given."""

    def __init__(
        self,
        bodies: list[Body],
        layers: int,
        seed: int,
        ambient: Rgb | None = None,
        reading: Reading | None = None,
    ) -> None:
        self.bodies = bodies
        self.layers = layers
        self.generator = np.random.default_rng(seed)
        self.ambient = ambient
        self.reading = reading or Reading()

    def radiance(self, o: Array, d: Array, layer: int = 0) -> Array:
        """Light along rays [n, 3], one sample of everything random."""
        result = np.zeros((len(o), 3))
        if layer == self.layers or len(o) == 0:
            return result
        which, t = self._closest(o, d)
        for index, body in enumerate(self.bodies):
            rows = np.flatnonzero(which == index)
            if len(rows):
                p = o[rows] + t[rows, None] * d[rows]
                result[rows] = self._shade(body, p, -d[rows], layer)
        return result

    def _closest(self, o: Array, d: Array) -> tuple[NDArray[np.int64], Array]:
        distances = np.stack([body.distances(o, d) for body in self.bodies])
        which = np.argmin(distances, axis=0)
        t = np.min(distances, axis=0)
        return np.where(np.isfinite(t), which, -1), t

    def _shade(self, body: Body, p: Array, V: Array, layer: int) -> Array:
        m = body.material
        outward = body.normals(p)
        inside = dot(outward, V) < 0.0
        N = np.where(inside[:, None], -outward, outward)
        light = np.tile(np.asarray(body.radiance), (len(p), 1))
        if self.reading.fronts_only:
            light[inside] = 0.0
        for source in self.bodies:
            if any(source.radiance) and source is not body:
                light += self._from_point(m, p, N, V, source, self._light_point(source, len(p)))
        light += np.asarray(m.ambient) * self._ambient(p, N)
        c = dot(N, V)[:, None]
        eta = np.where(inside, m.ior, 1.0 / m.ior)[:, None]
        k = 1.0 - eta**2 * (1.0 - c**2)
        total = k[:, 0] < 0.0
        root = np.sqrt(np.maximum(k, 0.0))
        mirror = np.full(len(p), m.reflection)
        refraction = np.where(total, 0.0, m.transmission)
        if self.reading.total_reflection_feeds_the_mirror:
            mirror = mirror + np.where(total, m.transmission, 0.0)
        if m.dielectric:
            s = (eta * c - root) / (eta * c + root)
            q = (c - eta * root) / (c + eta * root)
            mirror = np.where(total, 1.0, 0.5 * (s**2 + q**2)[:, 0])
            refraction = 1.0 - mirror
        for weight, direction in (
            (mirror, 2.0 * c * N - V),
            (refraction, (eta * c - root) * N - eta * V),
        ):
            rows = np.flatnonzero(weight > 0.0)
            child = self.radiance(p[rows], unit(direction[rows]), layer + 1)
            light[rows] += weight[rows, None] * child
        return light

    def _light_point(self, source: Body, count: int) -> Array:
        centre = np.asarray(source.centre)
        if self.ambient is not None:
            return np.tile(centre, (count, 1))
        if source.kind == "square":
            xy = self.generator.uniform(-source.size, source.size, (count, 2))
            return centre + np.column_stack([xy, np.zeros(count)])
        w = unit(self.generator.standard_normal((count, 3)))
        r = np.cbrt(self.generator.random((count, 1)))
        if self.reading.lights_are_sampled_on_the_surface:
            r[:] = 1.0
        return centre + source.size * r * w

    def _from_point(
        self, m: Material, p: Array, N: Array, V: Array, source: Body, q: Array
    ) -> Array:
        """Equations 2 and 3 for one light point, with its shadow ray."""
        distance = np.sqrt(dot(q - p, q - p))
        L = (q - p) / distance[:, None]
        cosine = dot(L, N)
        visible = cosine > 0.0
        for other in self.bodies:
            clear = self.reading.light_passes_through_glass and other.material.dielectric
            if other is not source and not clear:
                rows = np.flatnonzero(visible)
                visible[rows] = other.distances(p[rows], L[rows]) > distance[rows] * (1.0 - 1e-9)
        R = 2.0 * cosine[:, None] * N - L
        shine = np.maximum(dot(R, V), 0.0) ** m.exponent
        value = np.asarray(m.diffuse) * cosine[:, None] + np.asarray(m.specular) * shine[:, None]
        return np.where(visible[:, None], value * np.asarray(source.radiance), 0.0)

    def _ambient(self, p: Array, N: Array) -> Array:
        if self.ambient is not None:
            return np.tile(np.asarray(self.ambient), (len(p), 1))
        w = unit(self.generator.standard_normal((len(p), 3)))
        if self.reading.ambient_is_cosine_weighted:
            w = unit(w + N)
        w = np.where(dot(w, N)[:, None] < 0.0, -w, w)
        which, t = self._closest(p, w)
        result = np.zeros_like(p)
        for index, body in enumerate(self.bodies):
            rows = np.flatnonzero(which == index)
            if not len(rows):
                continue
            at = p[rows] + t[rows, None] * w[rows]
            normal = body.normals(at)
            normal *= np.where(dot(normal, w[rows]) > 0.0, -1.0, 1.0)[:, None]
            if self.reading.ambient_sees_emission:
                result[rows] += np.asarray(body.radiance)
            for source in self.bodies:
                if any(source.radiance) and source is not body:
                    centre = np.tile(np.asarray(source.centre), (len(rows), 1))
                    result[rows] += self._from_point(
                        body.material, at, normal, -w[rows], source, centre
                    )
        return result
