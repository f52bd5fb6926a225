"""Answers of convex objects alone under a uniform sky: what loses no energy cannot be seen.

`path` alone: the models of the paper know no sky.
"""

from __future__ import annotations

import itertools

import numpy as np

from harness.scene import Material, RenderSettings, Scene
from reference.analytic import forms
from reference.analytic.forms import Array
from reference.analytic.view import AnswerError, Hit, look, sphere_of, triangles_of

HEAD_ON = 1e-3
"""Largest angle, in radians, between camera and normal of a plate that is seen head-on."""


def _alone(scene: Scene) -> tuple[Hit, Array]:
    """The middle of the one object, which fills the picture, and the sky's radiance."""
    if len(scene.shapes) != 1 or scene.environment is None or scene.lights:
        raise AnswerError(f"{scene.name}: one object under a constant environment is needed")
    for x, y in itertools.product((0.0, 1.0), repeat=2):
        look(scene, x, y)
    return look(scene), np.array(scene.environment)


def _is_convex(scene: Scene) -> bool:
    """Whether no corner of the one mesh lies in front of any of its faces; spheres are convex."""
    corners = triangles_of(scene, scene.shapes[0])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = corners.reshape(-1, 3)
    heights = points @ normals.T - np.sum(normals * corners[:, 0], axis=1)
    return bool(heights.max(initial=0.0) < 1e-6 * np.abs(points).max(initial=1.0))


def furnace_diffuse(scene: Scene, settings: RenderSettings) -> Array | None:
    """A convex diffuse object: rho L, since every point sees the whole of the sky."""
    if settings.model != "path" or settings.max_depth < 2:
        return None
    hit, sky = _alone(scene)
    if not _is_convex(scene) or hit.material != Material(
        name=hit.material.name,
        kind="phong",
        diffuse=hit.material.diffuse,
        ambient=hit.material.ambient,
        twosided=hit.material.twosided,
        location=hit.material.location,
    ):
        raise AnswerError(f"{scene.name}: the object must be convex and diffuse")
    return hit.material.diffuse * sky


def furnace_mirror(scene: Scene, settings: RenderSettings) -> Array | None:
    """A convex mirror: its reflection times L, at every angle."""
    if settings.model != "path" or settings.max_depth < 2:
        return None
    hit, sky = _alone(scene)
    material = hit.material
    others = max(*material.diffuse, *material.specular, material.transmission)
    if not _is_convex(scene) or material.kind != "phong" or others > 0.0:
        raise AnswerError(f"{scene.name}: the object must be a convex mirror")
    return material.reflection * sky


def furnace_glass(scene: Scene, settings: RenderSettings, order: int = 32) -> Array | None:
    """A glass sphere: L, less what still runs inside it at the path's last segment.

    `forms.glass_sphere_share` at the angle of each place of the film, by a Gauss-Legendre rule of
    `order` squared points.
    """
    if settings.model != "path" or settings.max_depth < 2:
        return None
    hit, sky = _alone(scene)
    sphere_of(scene, hit.shape)
    if hit.material.kind != "dielectric" or hit.material.ior <= 1.0:
        raise AnswerError(f"{scene.name}: the object must be a sphere of glass")
    nodes, weights = np.polynomial.legendre.leggauss(order)
    places = 0.5 * (nodes + 1.0)
    hits = [look(scene, x, y) for x, y in itertools.product(places, repeat=2)]
    cosines = np.array([at.normal @ at.viewer for at in hits])
    shares = forms.glass_sphere_share(cosines, hit.material.ior, settings.max_depth)
    return sky * float(np.outer(weights, weights).ravel() @ shares) / 4.0


def furnace_phong(scene: Scene, settings: RenderSettings) -> Array | None:
    """A `phong` plate seen head-on: (k_d + k_s + reflection) L.

    The lobe k_s (alpha + 2) / (2 pi) cos^alpha is centred on the normal there, and its integral
    times cos theta over the hemisphere is k_s: the constant of Lafortune and Willems is exact.
    """
    if settings.model != "path" or settings.max_depth < 2:
        return None
    hit, sky = _alone(scene)
    material = hit.material
    if material.kind != "phong" or material.transmission > 0.0:
        raise AnswerError(f"{scene.name}: the plate must be of phong that transmits nothing")
    if float(np.linalg.norm(np.cross(hit.normal, hit.viewer))) > HEAD_ON:
        raise AnswerError(f"{scene.name}: the plate must be seen head-on")
    return (np.add(material.diffuse, material.specular) + material.reflection) * sky
