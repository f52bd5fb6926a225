"""Answers of closed rooms and of glass: light that is reflected over and over."""

from __future__ import annotations

import math

import numpy as np
from scipy import integrate

from harness.scene import RenderSettings, Scene, Shape
from reference.analytic import forms
from reference.analytic.forms import Array
from reference.analytic.view import (
    AnswerError,
    centroid,
    look,
    only_light,
    sphere_of,
    triangle_areas,
    triangles_of,
)

ON_AXIS = 1e-3
"""How far a point that belongs on an axis may lie beside it, in radii."""


def _radiant_room(scene: Scene) -> tuple[Shape, Array]:
    light, shape = only_light(scene)
    if len(scene.shapes) != 1:
        raise AnswerError(f"{scene.name}: one shape must be both the room and its light")
    return shape, np.array(light.radiance)


def emitting_box(scene: Scene, settings: RenderSettings) -> Array | None:
    """A closed room whose every wall emits L and reflects a, one shape.

    `path`: every path sees L at each of its D vertices, L (1 - a^D) / (1 - a). In `haste` and
    `whitted` the room is one light, which is never lit by itself: L, and in `whitted` k_a times
    `ambient` with it.
    """
    shape, radiance = _radiant_room(scene)
    material = scene.materials[shape.material]
    if max(*material.specular, material.reflection, material.transmission) > 0.0:
        raise AnswerError(f"{scene.name}: the walls must be diffuse")
    if settings.model == "path":
        return radiance * forms.geometric(np.array(material.diffuse), settings.max_depth)
    if settings.model == "whitted":
        return radiance + np.multiply(material.ambient, settings.ambient)
    return radiance


def mirror_box(scene: Scene, settings: RenderSettings) -> Array | None:
    """A closed room of mirrors that emit L: L (1 - a^D) / (1 - a), the same in every model.

    D is the depth of `path` and the number of layers of the others; a is the mirrors' reflection.
    """
    shape, radiance = _radiant_room(scene)
    material = scene.materials[shape.material]
    if max(*material.diffuse, *material.specular, *material.ambient, material.transmission) > 0.0:
        raise AnswerError(f"{scene.name}: the walls must do nothing but mirror and emit")
    terms = settings.max_depth if settings.model == "path" else settings.max_layers
    return radiance * float(forms.geometric(material.reflection, terms))


def integrating_sphere(scene: Scene, settings: RenderSettings) -> Array | None:
    """A sphere of two halves, one emitting L; seen is the pole of the dark one.

    `path`: between points of a sphere the form factor of an area is its share of the sphere, so
    every bounce brings rho f L: L sum over k = 1 .. D-1 of rho^k f, f the share that emits.

    `haste`: the direct light of a point at angle t from the pole of the bright half comes at the
    cosine cos(t/2); its mean over the half is 4/3 (1 - 2^(-3/2)). Ambient rays at cosine mu, each
    mu as likely as any other, hit the wall at angle phi from the dark pole, cos phi = 1 - 2 mu^2:
    beyond the equator on the light, which is not lit by itself, before it (mu < 1/sqrt 2) on wall
    that the light's centroid, R/2 above the equator, lights at the cosine
    (1 + cos phi / 2) / sqrt(5/4 + cos phi). `whitted`: the centroid stands straight above.

    The scene's halves are polyhedra, so this is their limit; reference/analytic/README.md states
    how far they are from it.
    """
    hit = look(scene)
    light, bright = only_light(scene)
    halves = [triangles_of(scene, shape) for shape in scene.shapes]
    if len(halves) != 2 or bright is hit.shape:
        raise AnswerError(f"{scene.name}: two halves are needed, and a camera on the dark one")
    areas = [float(triangle_areas(corners).sum()) for corners in halves]
    share = areas[scene.shapes.index(bright)] / sum(areas)
    axis = centroid(scene, bright) - centroid(scene, hit.shape)
    offset = hit.point - centroid(scene, bright)
    beside = np.linalg.norm(np.cross(axis, offset)) / np.linalg.norm(axis) ** 2
    if abs(share - 0.5) > ON_AXIS or beside > ON_AXIS:
        raise AnswerError(f"{scene.name}: the camera must look at the pole of the dark half")
    diffuse, radiance = np.array(hit.material.diffuse), np.array(light.radiance)
    if settings.model == "path":
        terms = forms.geometric(diffuse, settings.max_depth) - 1.0
        return terms * share * radiance
    if settings.model == "whitted":
        return diffuse * radiance + np.multiply(hit.material.ambient, settings.ambient)
    direct = 4.0 / 3.0 * (1.0 - 2.0**-1.5)
    ambient, _ = integrate.quad(_dark_wall_cosine, 0.0, math.sqrt(0.5), epsabs=1e-12)
    return diffuse * radiance * (direct + np.multiply(hit.material.ambient, ambient))


def _dark_wall_cosine(mu: float) -> float:
    """Cosine towards the bright half's centroid where an ambient ray at cosine mu hits the wall."""
    cosine = 1.0 - 2.0 * mu * mu
    return (1.0 + 0.5 * cosine) / math.sqrt(1.25 + cosine)


def glass_slab(scene: Scene, settings: RenderSettings) -> Array | None:
    """A light behind a slab of glass, seen through it at normal incidence.

    L times `forms.slab_transmittance`, the same series in every model: D is the depth of `path`
    and the number of layers of the others. Radiance is scaled by eta^2 on entry and back on exit.
    """
    hit = look(scene)
    light, shape = only_light(scene)
    material = scene.materials[shape.material]
    dark = max(*material.diffuse, *material.specular, *material.ambient, material.reflection) == 0
    parallel = hit.normal @ hit.viewer > 1.0 - 1e-6
    if hit.material.kind != "dielectric" or len(scene.shapes) != 2 or not (dark and parallel):
        raise AnswerError(f"{scene.name}: a slab of glass head-on before a black light is needed")
    depth = settings.max_depth if settings.model == "path" else settings.max_layers
    return np.multiply(light.radiance, forms.slab_transmittance(hit.material.ior, depth))


def ambient_dome(scene: Scene, settings: RenderSettings) -> Array | None:
    """A patch in the middle of a dome, which reflects nothing but the ambient estimate.

    The light is a small sphere, r, at height a on the axis of the dome, B. A direction at cosine mu
    to the axis hits the dome where the light's centre shines at the cosine
    g = (B - a mu) / sqrt(B^2 + a^2 - 2 a B mu) on a normal that points straight back at the patch,
    so that R . V is g too. `haste`: k_a L times the integral over mu from 0 to sqrt(1 - (r/a)^2) of
    k_d g + k_s g^alpha; steeper directions hit the light, which is not lit by itself. `whitted`:
    k_a times `ambient`. `path` knows no such term.
    """
    if settings.model == "path":
        return None
    hit = look(scene)
    light, shape = only_light(scene)
    if max(*hit.material.diffuse, *hit.material.specular, hit.material.reflection) > 0.0:
        raise AnswerError(f"{scene.name}: the patch must reflect ambient light alone")
    if settings.model == "whitted":
        return np.multiply(hit.material.ambient, settings.ambient)
    domes = [other for other in scene.shapes if other is not shape and other is not hit.shape]
    if len(domes) != 1:
        raise AnswerError(f"{scene.name}: there must be one dome, not {len(domes)}")
    centre, large = sphere_of(scene, domes[0])
    lamp, radius = sphere_of(scene, shape)
    height = float((lamp - hit.point) @ hit.normal)
    beside = float(np.linalg.norm(lamp - hit.point - height * hit.normal))
    if max(beside, float(np.linalg.norm(centre - hit.point))) > ON_AXIS * large:
        raise AnswerError(f"{scene.name}: patch and light must lie on the axis of the dome")
    material = scene.materials[domes[0].material]

    def cosine(mu: float) -> float:
        return (large - height * mu) / math.sqrt(large**2 + height**2 - 2.0 * height * large * mu)

    steepest = math.sqrt(1.0 - (radius / height) ** 2)
    diffuse, _ = integrate.quad(cosine, 0.0, steepest, epsabs=1e-12)
    specular, _ = integrate.quad(
        lambda mu: cosine(mu) ** material.exponent, 0.0, steepest, epsabs=1e-12
    )
    reflected = np.multiply(material.diffuse, diffuse) + np.multiply(material.specular, specular)
    return hit.material.ambient * reflected * light.radiance
