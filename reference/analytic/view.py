"""What a scene's answer is read from: the point that the camera looks at, and the lights.

Everything is computed in float64 from the arrays of an imported scene, by testing every shape:
scenes with a known answer are small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from harness.scene import Light, Material, Scene, Shape
from reference.analytic.forms import Array

SELF_HIT = 1e-6
"""Hits nearer than this share of the scene's size are the surface that a ray starts on."""


class AnswerError(ValueError):
    """A scene is not of the form that its answer is derived for; the message says what differs."""


@dataclass(frozen=True, slots=True)
class Hit:
    """A point that a camera ray hits. Vectors are float64 [3], normals turned to the viewer."""

    point: Array
    normal: Array
    viewer: Array
    """unit vector back along the ray"""
    shape: Shape
    material: Material

    @property
    def mirrored(self) -> Array:
        """The viewer mirrored at the normal: R . V of a light equals its L . mirrored."""
        return 2.0 * (self.normal @ self.viewer) * self.normal - self.viewer

    def cosine(self, point: Array) -> float:
        """Cosine at the hit of the angle towards a point."""
        return float(self.normal @ (point - self.point) / np.linalg.norm(point - self.point))


def triangles_of(scene: Scene, shape: Shape) -> Array:
    """Corners of a mesh, float64 [n, 3, 3]; of a sphere there are none."""
    if shape.kind == "sphere":
        return np.zeros((0, 3, 3))
    indices = scene.triangles[shape.first : shape.first + shape.count]
    return scene.vertices[indices].astype(np.float64)


def sphere_of(scene: Scene, shape: Shape) -> tuple[Array, float]:
    """Centre and radius of a sphere."""
    if shape.kind != "sphere":
        raise AnswerError(f'{scene.name}: shape "{shape.name}" must be a sphere')
    x, y, z, radius = (float(value) for value in scene.spheres[shape.first])
    return np.array([x, y, z]), radius


def _hit_triangles(origin: Array, direction: Array, corners: Array) -> tuple[float, Array]:
    """Distance of the nearest of triangles [n, 3, 3] and its normal (Moeller and Trumbore 1997)."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(direction, second)
    determinant = np.sum(first * across, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = origin - corners[:, 0]
        u = np.sum(offset * across, axis=1) / determinant
        along = np.cross(offset, first)
        v = along @ direction / determinant
        t = np.sum(second * along, axis=1) / determinant
        slack = 1e-12
        inside = (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack)
    t = np.where(inside & np.isfinite(t), t, math.inf)
    size = np.abs(corners).max(initial=1.0)
    t[t <= SELF_HIT * size] = math.inf
    if not t.size or math.isinf(t.min()):
        return math.inf, np.zeros(3)
    nearest = int(np.argmin(t))
    return float(t[nearest]), np.cross(first[nearest], second[nearest])


def _hit_sphere(
    origin: Array, direction: Array, sphere: tuple[Array, float]
) -> tuple[float, Array]:
    centre, radius = sphere
    middle = float((centre - origin) @ direction)
    chord = radius**2 - float(np.sum((centre - origin - middle * direction) ** 2))
    if chord <= 0.0:
        return math.inf, np.zeros(3)
    for t in (middle - math.sqrt(chord), middle + math.sqrt(chord)):
        if t > SELF_HIT * radius:
            return t, origin + t * direction - centre
    return math.inf, np.zeros(3)


def trace(scene: Scene, origin: Array, direction: Array) -> tuple[float, Array, int]:
    """Distance, unnormalised normal and shape index of the nearest hit; inf and -1 for none."""
    best: tuple[float, Array, int] = (math.inf, np.zeros(3), -1)
    for index, shape in enumerate(scene.shapes):
        if shape.kind == "sphere":
            found = _hit_sphere(origin, direction, sphere_of(scene, shape))
        else:
            found = _hit_triangles(origin, direction, triangles_of(scene, shape))
        if found[0] < best[0]:
            best = (*found, index)
    return best


def look(scene: Scene, x: float = 0.5, y: float = 0.5) -> Hit:
    """What the camera sees at a place of the film, both coordinates from 0 to 1, y down.

    Raises
    ------
    AnswerError
        It sees nothing.
    """
    camera = scene.camera
    corner, dx, dy = (np.array(value) for value in (camera.corner, camera.dx, camera.dy))
    direction = corner + x * camera.width * dx + y * camera.height * dy
    direction /= np.linalg.norm(direction)
    origin = np.array(camera.origin)
    distance, normal, index = trace(scene, origin, direction)
    if index < 0:
        raise AnswerError(f"{scene.name}: the camera sees nothing at ({x:g}, {y:g}) of the film")
    normal /= np.linalg.norm(normal)
    if normal @ direction > 0.0:
        normal = -normal
    shape = scene.shapes[index]
    material = scene.materials[shape.material]
    return Hit(origin + distance * direction, normal, -direction, shape, material)


def sees(scene: Scene, origin: Array, target: Array, owner: Shape) -> bool:
    """Whether nothing but `owner` lies between two points (docs/lighting.md, `visible`)."""
    distance = float(np.linalg.norm(target - origin))
    direction = (target - origin) / distance
    others = [shape for shape in scene.shapes if shape is not owner]
    for shape in others:
        if shape.kind == "sphere":
            t, _ = _hit_sphere(origin, direction, sphere_of(scene, shape))
        else:
            t, _ = _hit_triangles(origin, direction, triangles_of(scene, shape))
        if t < distance:
            return False
    return True


def only_light(scene: Scene) -> tuple[Light, Shape]:
    """The one light of a scene and its shape."""
    if len(scene.lights) != 1 or scene.environment is not None:
        raise AnswerError(f"{scene.name}: one light is needed, and no environment")
    light = scene.lights[0]
    return light, scene.shapes[light.shape]


def centroid(scene: Scene, shape: Shape) -> Array:
    """Centre of a sphere, or area-weighted mean of the centroids of a mesh's triangles."""
    if shape.kind == "sphere":
        return sphere_of(scene, shape)[0]
    corners = triangles_of(scene, shape)
    areas = triangle_areas(corners)
    return np.asarray(areas @ corners.mean(axis=1) / areas.sum())


def triangle_areas(corners: Array) -> Array:
    """Areas of triangles [n, 3, 3] -> [n]."""
    edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(edges, axis=1)


def require_black(scene: Scene, seen: Shape) -> None:
    """Raise AnswerError unless `seen` alone reflects: then its light comes from lights only."""
    for shape in scene.shapes:
        material = scene.materials[shape.material]
        colours = (*material.diffuse, *material.specular)
        factors = (material.reflection, material.transmission)
        if shape is not seen and (material.kind != "phong" or max(*colours, *factors) > 0.0):
            raise AnswerError(f'{scene.name}: shape "{shape.name}" must be black')
