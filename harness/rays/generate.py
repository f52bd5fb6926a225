"""Rays of every class through a scene, from its camera and from where those rays hit.

What is random comes from Philox, keyed by the seed and by the class, so that the rays of a class
depend on no other class. Rays of a class come in the order in which an image's do: row by row over
the film, and so do those that start where they hit, but for the classes that are random or shuffled
on purpose.
"""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harness.rays.classes import CLASSES
from harness.rays.parts import Parts, Rows
from harness.scene import Camera, Scene
from harness.tracers.rays import RayHits, Rays, make_rays

Floats = NDArray[np.float64]
Trace = Callable[[Rays], RayHits]

AMBIENT_SHARE = 0.1
"""Reach of an ambient ray, as a share of the scene's extent."""

OFFSET_OPERATIONS = 16
"""Rounded operations that a spawned ray's offset bounds (haste_cuda/core/geometry/offset.h)."""

SHORT_OF_THE_LIGHT = 1.0 - 2.0**-10
"""Where a shadow ray ends on its way to a point of a light: before the light itself."""


LIGHT_DRAWS = 64
"""Points of lights that are drawn for a hit, at most, before fewer hits have to do."""


class RaysError(Exception):
    """The rays of a scene cannot be made; the message says why."""


@dataclass(frozen=True, slots=True)
class _Points:
    """Where rays hit: float64 [H, 3], the normal towards where they came from, the shape [H]."""

    position: Floats
    normal: Floats
    scale: Floats
    """largest absolute coordinate that took part in computing the point, [H]"""

    def __len__(self) -> int:
        return len(self.position)

    def spread(self, rows: Rows, count: int) -> "_Points":
        """Some of `count` points in the same order, each as often as the others within one."""
        place = rows * len(self) // count
        return _Points(self.position[place], self.normal[place], self.scale[place])


@dataclass(frozen=True, slots=True)
class _Sphere:
    """Points drawn uniformly from the unit sphere: what is drawn of each, [N]."""

    z: Floats
    angle: Floats

    @classmethod
    def draw(cls, count: int, random: np.random.Generator) -> "_Sphere":
        return cls(random.uniform(-1.0, 1.0, count), random.uniform(0.0, 2.0 * np.pi, count))

    def points(self, rows: Rows) -> Floats:
        z, angle = self.z[rows], self.angle[rows]
        across = np.sqrt(1.0 - z * z)
        return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


def scene_box(scene: Scene) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates of everything in a scene."""
    corners = scene.vertices[np.unique(scene.triangles)].astype(np.float64)
    centres, radii = np.split(scene.spheres.astype(np.float64), [3], axis=1)
    points = np.concatenate([corners, centres - radii, centres + radii])
    return points.min(axis=0), points.max(axis=0)


def extent(scene: Scene) -> float:
    """Diagonal of a scene's box."""
    low, high = scene_box(scene)
    return float(np.linalg.norm(high - low))


def generate_rays(
    scene: Scene,
    trace: Trace,
    count: int,
    *,
    seed: int = 0,
    inside: bool = False,
    threads: int = 1,
) -> dict[str, Rays]:
    """Make rays of every class.

    Parameters
    ----------
    scene
        The scene.
    trace
        A tracer of the scene; finds the closest hits from which secondary rays start.
    count
        Rays of each class.
    seed
        Of the generators; the rays are the same for the same seed.
    inside
        Whether bounces start on the far side of what the camera sees.
    threads
        Of this processor; the rays are the same at any number.

    Returns
    -------
    dict
        By class, in the order of `CLASSES`.

    Raises
    ------
    RaysError
        Neither camera nor first bounce hits anything.
    """

    def random(name: str) -> np.random.Generator:
        key = np.array([seed, list(CLASSES).index(name)], np.uint64)
        return np.random.Generator(np.random.Philox(key=key))

    reach = AMBIENT_SHARE * extent(scene)
    # What is drawn, one number after another, is drawn of several classes side by side.
    with ThreadPoolExecutor(threads) as pool, ThreadPoolExecutor(threads) as beside:
        parts = Parts(pool)
        uniform = beside.submit(_uniform_rays, parts, scene, count, random("random"))
        camera = _camera_rays(parts, scene.camera, count, random("camera"))
        seen = _hit_points(parts, scene, camera, trace(camera), "camera")
        shadow = beside.submit(_shadow_rays, parts, scene, seen, count, random("shadow"))
        ambient = beside.submit(_diffuse_rays, parts, seen, count, random("ambient"), reach)
        # Outside faces the camera, inside turns away from it; later bounces stay where they are.
        start = replace(seen, normal=-seen.normal) if inside else seen
        diffuse1 = _diffuse_rays(parts, start, count, random("diffuse1"), math.inf)
        shuffled = beside.submit(_shuffled, diffuse1, random("shuffled"))
        bounced = _hit_points(parts, scene, diffuse1, trace(diffuse1), "diffuse1")
        made = {
            "camera": camera,
            "diffuse1": diffuse1,
            "diffuse2": _diffuse_rays(parts, bounced, count, random("diffuse2"), math.inf),
            "shadow": shadow.result(),
            "ambient": ambient.result(),
            "shuffled": shuffled.result(),
            "random": uniform.result(),
            "random_any": uniform.result(),
        }
    return {name: made[name] for name in CLASSES}


def _rays(
    parts: Parts, count: int, make: Callable[[Rows], tuple[Floats, Floats]], t_max: float
) -> Rays:
    """Rays whose origins and directions `make` gives, some rows at a time."""
    origins, directions = np.empty((count, 3), np.float32), np.empty((count, 3), np.float32)
    parts.fill(make, origins, directions)
    return make_rays(origins, directions, 0.0, t_max)


def _camera_rays(parts: Parts, camera: Camera, count: int, random: np.random.Generator) -> Rays:
    """A ray through a random point of each pixel of a film that has as many pixels as rays."""
    aspect = camera.width / camera.height
    width = max(1, round(math.sqrt(count * aspect)))
    height = -(-count // width)
    within = random.random((count, 2))

    def make(rows: Rows) -> tuple[Floats, Floats]:
        pixel = np.stack([rows % width, rows // width], axis=1)
        # The film of the scene, cut into more pixels.
        place = (pixel + within[rows]) / [width, height] * [camera.width, camera.height]
        direction = (
            np.array(camera.corner)
            + place[:, :1] * np.array(camera.dx)
            + place[:, 1:] * np.array(camera.dy)
        )
        return np.array(camera.origin) + camera.near * direction, _unit(direction)

    return _rays(parts, count, make, math.inf)


def _unit(vectors: Floats) -> Floats:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _hit_points(parts: Parts, scene: Scene, rays: Rays, hits: RayHits, name: str) -> _Points:
    """The points that rays hit, in double precision, and the normals on the rays' side.

    A point is where the ray meets the plane of the triangle, or the sphere, that was hit.
    """
    found = np.flatnonzero(hits.hit)
    if not len(found):
        raise RaysError(f"{scene.name}: no ray of the class {name} hits anything")

    def make(rows: Rows) -> tuple[Floats, Floats, Floats]:
        points = _some_points(scene, rays, hits, found[rows])
        return points.position, points.normal, points.scale

    count = len(found)
    points = _Points(np.empty((count, 3)), np.empty((count, 3)), np.empty(count))
    parts.fill(make, points.position, points.normal, points.scale)
    return points


def _some_points(scene: Scene, rays: Rays, hits: RayHits, found: Rows) -> _Points:
    origin = rays.origins[found].astype(np.float64)
    direction = rays.directions[found].astype(np.float64)
    primitive = hits.primitive[found].astype(np.int64)
    t = hits.t[found].astype(np.float64)
    normal = np.empty_like(origin)
    scale = np.empty(len(found))
    mesh = primitive < len(scene.triangles)
    corners = scene.vertices[scene.triangles[primitive[mesh]]].astype(np.float64)
    normal[mesh] = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    scale[mesh] = np.abs(corners).max(axis=(1, 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        plane = np.einsum("ij,ij->i", corners[:, 0] - origin[mesh], normal[mesh]) / np.einsum(
            "ij,ij->i", direction[mesh], normal[mesh]
        )
    # A ray along the plane of what it hits meets it nowhere in particular.
    t[mesh] = np.where(np.isfinite(plane), plane, t[mesh])
    position = origin + t[:, None] * direction
    balls = scene.spheres[primitive[~mesh] - len(scene.triangles)].astype(np.float64)
    outwards = _unit(position[~mesh] - balls[:, :3])
    position[~mesh] = balls[:, :3] + balls[:, 3:] * outwards
    normal[~mesh] = outwards
    scale[~mesh] = np.abs(balls[:, :3]).max(axis=1, initial=0.0) + balls[:, 3]
    away = np.einsum("ij,ij->i", normal, direction) > 0.0
    normal[away] *= -1.0
    return _Points(position, _unit(normal), np.maximum(scale, np.abs(position).max(axis=1)))


def _offset(points: _Points) -> Floats:
    """Origins off the surface by the error of the point and of the test that could find it again.

    The bound of haste_cuda/core/geometry/offset.h, gamma(16) times the scale (Higham 2002, lemma
    3.1), with the unit roundoff of the single precision in which the origins are stored.
    """
    roundoff = OFFSET_OPERATIONS * 2.0**-24
    distance = roundoff / (1.0 - roundoff) * points.scale
    return points.position + distance[:, None] * points.normal


def _diffuse_rays(
    parts: Parts, points: _Points, count: int, random: np.random.Generator, reach: float
) -> Rays:
    """Cosine-distributed rays about the normals: the normal plus a point of the unit sphere."""
    sphere = _Sphere.draw(count, random)

    def make(rows: Rows) -> tuple[Floats, Floats]:
        spread = points.spread(rows, count)
        direction = spread.normal + sphere.points(rows)
        length = np.linalg.norm(direction, axis=1, keepdims=True)
        # The point opposite to the normal has no direction; nothing has a chance of drawing it
        # twice.
        direction = np.where(length > 2.0**-20, direction, spread.normal)
        return _offset(spread), _unit(direction)

    return _rays(parts, count, make, reach)


def _shuffled(rays: Rays, random: np.random.Generator) -> Rays:
    order = random.permutation(len(rays))
    return Rays(*(getattr(rays, part)[order] for part in Rays.__slots__))


def _shadow_rays(
    parts: Parts, scene: Scene, points: _Points, count: int, random: np.random.Generator
) -> Rays:
    """Rays towards points drawn uniformly from a light's surface, each light as often as any.

    A point behind the surface is drawn anew: nobody traces what the surface itself hides. Without
    lights rays go into the sky: uniformly over the hemisphere of the normal, without end.
    """
    if not scene.lights:
        return _sky_rays(parts, points, count, random)
    surfaces = [_Surface.of(scene, light.shape) for light in scene.lights]
    target, faces = np.empty((count, 3)), np.empty(count, bool)
    starts, targets = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for _ in range(LIGHT_DRAWS):
        lights = _Lights.draw(surfaces, count, random)

        def draw(rows: Rows, lights: "_Lights" = lights) -> tuple[Floats, NDArray[np.bool_]]:
            spread, drawn = points.spread(rows, count), lights.points(rows)
            towards = drawn - _offset(spread)
            return drawn, np.einsum("ij,ij->i", towards, spread.normal) > 0.0

        parts.fill(draw, target, faces)
        starts.append(np.flatnonzero(faces))
        targets.append(target[faces])
        if sum(map(len, starts)) >= count:
            break
    start, target = np.concatenate(starts), np.concatenate(targets)
    if not len(start):
        raise RaysError(f"{scene.name}: nothing that the camera sees faces a light")
    # In the order of the points, evenly from all of them.
    order = np.argsort(start, kind="stable")

    def make(rows: Rows) -> tuple[Floats, Floats]:
        chosen = order[rows * len(start) // count]
        origin = _offset(points.spread(start[chosen], count))
        # Not of unit length: the ray parameter is the share of the way to the light.
        return origin, target[chosen] - origin

    return _rays(parts, count, make, SHORT_OF_THE_LIGHT)


def _sky_rays(parts: Parts, points: _Points, count: int, random: np.random.Generator) -> Rays:
    sphere = _Sphere.draw(count, random)

    def make(rows: Rows) -> tuple[Floats, Floats]:
        spread, direction = points.spread(rows, count), sphere.points(rows)
        below = np.einsum("ij,ij->i", direction, spread.normal) < 0.0
        direction[below] *= -1.0
        return _offset(spread), direction

    return _rays(parts, count, make, math.inf)


@dataclass(frozen=True, slots=True)
class _Surface:
    """A light's: a ball, centre and radius [4], or triangles [T, 3, 3] and the sums of their areas
    up to each, [T].
    """

    ball: Floats | None
    corners: Floats
    areas: Floats

    @classmethod
    def of(cls, scene: Scene, number: int) -> "_Surface":
        shape = scene.shapes[number]
        if shape.kind == "sphere":
            ball = scene.spheres[shape.first].astype(np.float64)
            return cls(ball, np.zeros((0, 3, 3)), np.zeros(0))
        triangles = scene.triangles[shape.first : shape.first + shape.count]
        corners = scene.vertices[triangles].astype(np.float64)
        edges = corners[:, 1:] - corners[:, :1]
        areas = np.cumsum(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1))
        return cls(None, corners, areas)

    def points(self, where: Floats, around: Floats) -> Floats:
        """Points drawn uniformly, by three uniform numbers each or a point of the unit sphere."""
        if self.ball is not None:
            return self.ball[:3] + self.ball[3] * around
        triangle = np.searchsorted(self.areas, where[:, 0] * self.areas[-1], side="right")
        triangle = np.minimum(triangle, len(self.corners) - 1)
        root = np.sqrt(where[:, 1])
        weights = np.stack([1.0 - root, root * (1.0 - where[:, 2]), root * where[:, 2]], axis=1)
        return np.einsum("nc,ncx->nx", weights, self.corners[triangle])


@dataclass(frozen=True, slots=True)
class _Lights:
    """Points on the lights: what is drawn of each."""

    surfaces: Sequence[_Surface]
    light: NDArray[np.int64]
    where: Floats
    around: _Sphere

    @classmethod
    def draw(
        cls, surfaces: Sequence[_Surface], count: int, random: np.random.Generator
    ) -> "_Lights":
        light = random.integers(len(surfaces), size=count)
        return cls(surfaces, light, random.random((count, 3)), _Sphere.draw(count, random))

    def points(self, rows: Rows) -> Floats:
        light, where, around = self.light[rows], self.where[rows], self.around.points(rows)
        points = np.empty((len(rows), 3))
        for number in np.unique(light):
            chosen = light == number
            points[chosen] = self.surfaces[number].points(where[chosen], around[chosen])
        return points


def _uniform_rays(parts: Parts, scene: Scene, count: int, random: np.random.Generator) -> Rays:
    """Origins uniform in the scene's box, directions uniform over the sphere."""
    low, high = scene_box(scene)
    within, sphere = random.random((count, 3)), _Sphere.draw(count, random)

    def make(rows: Rows) -> tuple[Floats, Floats]:
        return low + (high - low) * within[rows], sphere.points(rows)

    return _rays(parts, count, make, math.inf)
