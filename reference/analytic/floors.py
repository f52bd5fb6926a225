"""Answers of one lit surface: a floor under a light, where everything else is black.

Nothing returns light to the floor, so that direct light is all there is: in `path` from depth 2
on, and in `haste` with an ambient estimate of 0, as the surfaces that its rays hit reflect nothing.
"""

from __future__ import annotations

import math

import numpy as np

from harness.scene import RenderSettings, Scene, Shape
from reference.analytic import forms
from reference.analytic.forms import Array
from reference.analytic.view import (
    AnswerError,
    Hit,
    centroid,
    look,
    only_light,
    require_black,
    sees,
    sphere_of,
    triangle_areas,
    triangles_of,
)

ALIGNED = 1e-5
"""How far vectors may be from parallel, as a sine, and points from an axis, in radii."""


def whitted_floor(scene: Scene, settings: RenderSettings, hit: Hit) -> Array:
    """Equations 2 and 3 with one sample at the light's centroid, and k_a times `ambient`."""
    light, shape = only_light(scene)
    target = centroid(scene, shape)
    material = hit.material
    value = np.multiply(material.ambient, settings.ambient)
    cosine = hit.cosine(target)
    if cosine > 0.0 and sees(scene, hit.point, target, shape):
        towards = (target - hit.point) / np.linalg.norm(target - hit.point)
        highlight = max(0.0, float(towards @ hit.mirrored)) ** material.exponent
        reflected = np.multiply(material.diffuse, cosine)
        reflected += np.multiply(material.specular, highlight)
        value = value + reflected * light.radiance
    return value


def diffuse_floor(
    scene: Scene, settings: RenderSettings, hit: Hit, share: float, mean_cosine: float
) -> Array | None:
    """A diffuse floor, given its irradiance share (`path`) and mean cosine (`haste`)."""
    require_black(scene, hit.shape)
    if max(hit.material.specular) > 0.0 or hit.material.reflection > 0.0:
        raise AnswerError(f'{scene.name}: material "{hit.material.name}" must be diffuse')
    light, _ = only_light(scene)
    if settings.model == "whitted":
        return whitted_floor(scene, settings, hit)
    if settings.model == "path" and settings.max_depth < 2:
        return None
    reflected = np.multiply(hit.material.diffuse, light.radiance)
    return reflected * (share if settings.model == "path" else mean_cosine)


def sphere_light(scene: Scene, settings: RenderSettings) -> Array | None:
    """A sphere light wholly above the floor.

    `path`: rho L (R/d)^2 cos theta. `haste`: k_d L (1 - R^2 / (5 d^2)) cos theta.
    """
    hit = look(scene)
    centre, radius = sphere_of(scene, only_light(scene)[1])
    distance, cosine = float(np.linalg.norm(centre - hit.point)), hit.cosine(centre)
    if distance * cosine < radius:
        raise AnswerError(f"{scene.name}: the light must be wholly above the floor")
    share = forms.ball_share(radius, distance, cosine)
    mean_cosine = forms.ball_mean_cosine(radius, distance, cosine)
    return diffuse_floor(scene, settings, hit, share, mean_cosine)


def _disk_above(scene: Scene, hit: Hit, light: Shape) -> tuple[float, float]:
    """Radius of a disk light and its height above the hit; the imported polygon has its area."""
    corners = triangles_of(scene, light)
    radius = math.sqrt(float(triangle_areas(corners).sum()) / math.pi)
    offset = centroid(scene, light) - hit.point
    height = float(offset @ hit.normal)
    tilt = np.abs((corners.reshape(-1, 3) - hit.point) @ hit.normal - height).max()
    aside = float(np.linalg.norm(offset - height * hit.normal))
    if height <= 0.0 or max(tilt, aside) > ALIGNED * radius:
        raise AnswerError(f"{scene.name}: the disk must be parallel to the floor, above the point")
    return radius, height


def disk_light(scene: Scene, settings: RenderSettings) -> Array | None:
    """A disk light straight above. `path`: rho L R^2 / (R^2 + h^2); `haste`: its mean cosine."""
    hit = look(scene)
    radius, height = _disk_above(scene, hit, only_light(scene)[1])
    share = forms.disk_share(radius, height)
    return diffuse_floor(scene, settings, hit, share, forms.disk_mean_cosine(radius, height))


def soft_shadow(scene: Scene, settings: RenderSettings) -> Array | None:
    """The middle of the shadow of a sphere under a disk light, both straight above.

    `path`: rho L (R^2 / (R^2 + H^2) - (r / h)^2) with sphere r at h; `haste`: the mean cosine of
    the ring that is left. `whitted`, with its one sample in the middle, sees no light.
    """
    hit = look(scene)
    light = only_light(scene)[1]
    radius, height = _disk_above(scene, hit, light)
    blockers = [shape for shape in scene.shapes if shape.kind == "sphere"]
    if len(blockers) != 1:
        raise AnswerError(f"{scene.name}: one sphere must cast the shadow, not {len(blockers)}")
    centre, size = sphere_of(scene, blockers[0])
    distance = float(np.linalg.norm(centre - hit.point))
    sine = size / distance
    if 1.0 - hit.cosine(centre) > ALIGNED**2 or sine >= radius / math.hypot(radius, height):
        raise AnswerError(
            f"{scene.name}: the sphere must lie on the axis and hide part of the disk"
        )
    share = forms.disk_share(radius, height, sine)
    mean_cosine = forms.disk_mean_cosine(radius, height, sine)
    return diffuse_floor(scene, settings, hit, share, mean_cosine)


def rectangle_light(scene: Scene, settings: RenderSettings) -> Array | None:
    """A rectangular light parallel to the floor, anywhere above it.

    `path`: rho L F, F by Lambert's formula; `haste`: the closed mean cosine of a rectangle.
    """
    hit = look(scene)
    corners = triangles_of(scene, only_light(scene)[1])
    shares = forms.polygon_share(hit.point, hit.normal, corners)
    points = corners.reshape(-1, 3) - hit.point
    heights = points @ hit.normal
    # The edges of half the rectangle that meet at a right angle.
    edges = corners[0] - np.roll(corners[0], 1, axis=0)
    edges = edges[np.argsort(np.linalg.norm(edges, axis=1))[:2]]
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    if (
        len(corners) != 2
        or np.ptp(heights) > ALIGNED * heights[0]
        or shares.min() <= 0.0
        or abs(float(edges[0] @ edges[1])) > ALIGNED
    ):
        raise AnswerError(f"{scene.name}: the light must be a rectangle that faces the floor")
    (x, y) = ((float(values.min()), float(values.max())) for values in (points @ edges.T).T)
    mean_cosine = forms.rectangle_mean_cosine(x, y, float(heights.mean()))
    return diffuse_floor(scene, settings, hit, float(shares.sum()), mean_cosine)


def wall_sky(scene: Scene, settings: RenderSettings) -> Array | None:
    """A floor beside a black wall under a uniform sky, `path` alone: rho L (1 - F of the wall).

    F is Lambert's of the wall as it is; for a wall without ends, of height h at distance x, the
    answer is rho L (1 + x / sqrt(x^2 + h^2)) / 2.
    """
    if settings.model != "path" or settings.max_depth < 2:
        return None
    hit = look(scene)
    require_black(scene, hit.shape)
    if scene.environment is None or scene.lights:
        raise AnswerError(f"{scene.name}: a constant environment must be the only light")
    hidden = 0.0
    for shape in scene.shapes:
        if shape is not hit.shape:
            corners = triangles_of(scene, shape)
            if ((corners - hit.point) @ hit.normal).min() < -ALIGNED:
                raise AnswerError(f"{scene.name}: the wall must stand on the floor")
            hidden += abs(float(forms.polygon_share(hit.point, hit.normal, corners).sum()))
    return np.multiply(hit.material.diffuse, scene.environment) * (1.0 - hidden)


def highlight(scene: Scene, settings: RenderSettings) -> Array | None:
    """The highlight of a sphere light on a `phong` floor.

    `whitted` is exact. `path` integrates f cos theta over the cone of the light, and `haste` takes
    the mean over its volume of k_d cos theta + k_s (R . V)^alpha: integrals over the directions
    towards the ball, by `forms.ball_directions`.
    """
    hit = look(scene)
    require_black(scene, hit.shape)
    light, shape = only_light(scene)
    material = hit.material
    if settings.model == "whitted":
        return whitted_floor(scene, settings, hit)
    centre, radius = sphere_of(scene, shape)
    arm = centre - hit.point
    distance = float(np.linalg.norm(arm))
    if distance * hit.cosine(centre) < radius:
        raise AnswerError(f"{scene.name}: the light must be wholly above the floor")
    directions, solid, volume = forms.ball_directions(distance, radius, arm / distance)
    cosines = directions @ hit.normal
    lobes = np.maximum(directions @ hit.mirrored, 0.0) ** material.exponent
    diffuse, specular = np.array(material.diffuse), np.array(material.specular)
    if settings.model == "haste":
        reflected = diffuse * (volume @ cosines) + specular * (volume @ lobes)
    elif settings.max_depth < 2:
        return None
    else:
        normalised = (material.exponent + 2.0) / (2.0 * math.pi) * (solid @ (lobes * cosines))
        reflected = diffuse * (solid @ cosines) / math.pi + specular * normalised
    return reflected * light.radiance
