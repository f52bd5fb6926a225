"""The paper's lighting models on Dr.Jit arrays: equations 1 to 7 and 9, as in docs/lighting.md.

One child is followed at random where a surface has two, with probability proportional to their
weights and the sum of the weights as its own: the expectation is that of the full ray tree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reference.mitsuba.entities import Entities, Light, shape_identity
from reference.mitsuba.numeric import power_of_cosine


@dataclass(frozen=True, slots=True)
class ModelSettings:
    """What a model needs besides the scene; ``light_samples`` = 0 takes each light's centroid.

    ``ambient`` is the constant ambient light of `whitted`; None takes ``ambient_samples`` rays.
    """

    max_layers: int
    light_samples: int
    ambient_samples: int
    ambient: tuple[float, float, float] | None


@dataclass(slots=True)
class Hit:
    """A point that is shaded, with the vectors and constants of its equations."""

    si: Any
    identity: Any
    V: Any
    N: Any
    N_g: Any
    inside: Any
    diffuse: Any
    specular: Any
    exponent: Any


def read_hit(si: Any, direction: Any, entities: Entities, active: Any) -> Hit:
    """The hit of a ray that arrived along ``direction``; normals are turned to its side."""
    V = -direction
    inside = dr.dot(si.n, V) < 0.0
    N_g = dr.select(inside, -si.n, si.n)
    N = si.sh_frame.n
    N = dr.select(dr.dot(N, N_g) < 0.0, -N, N)
    identity = shape_identity(si.shape)
    return Hit(
        si=si,
        identity=identity,
        V=mi.Vector3f(V),
        N=mi.Normal3f(N),
        N_g=mi.Normal3f(N_g),
        inside=inside,
        diffuse=dr.gather(mi.Color3f, entities.diffuse, identity, active),
        specular=dr.gather(mi.Color3f, entities.specular, identity, active),
        exponent=dr.gather(mi.Float, entities.exponent, identity, active),
    )


def light_point(hit: Hit, light: Light, point: Any, active: Any) -> Any:
    """Diffuse and specular light that one point of ``light`` sends to ``hit``.

    One term of the sums of equations 2 and 3, or of 4 and 5, its shadow ray included.
    """
    to_light = point - hit.si.p
    L = dr.normalize(to_light)
    cosine = dr.dot(L, hit.N)
    active = active & (hit.identity != light.identity) & (dr.squared_norm(to_light) > 0.0)
    active &= (cosine > 0.0) & (dr.dot(L, hit.N_g) > 0.0)
    active &= dr.max(dr.maximum(hit.diffuse, hit.specular)) > 0.0
    if light.others is not None:
        active &= ~light.others.ray_test(hit.si.spawn_ray_to(point), active)
    R = 2.0 * cosine * hit.N - L
    phong = hit.diffuse * cosine + hit.specular * power_of_cosine(R, hit.V, hit.exponent)
    return dr.select(active, phong * mi.Color3f(light.radiance), 0.0)


def sample_light(light: Light, sampler: Any, active: Any) -> Any:
    """A point of the light: uniform in the volume of a sphere, by area on a mesh."""
    if light.sphere is None:
        return light.shape.sample_position(0.0, sampler.next_2d(active), active).p
    centre, radius = light.sphere
    distance = radius * dr.cbrt(sampler.next_1d(active))
    direction = mi.warp.square_to_uniform_sphere(sampler.next_2d(active))
    return mi.Point3f(centre) + distance * direction


@dr.syntax
def direct_light(hit: Hit, light: Light, samples: int, sampler: Any, active: Any) -> Any:
    """Diffuse and specular light of one light, equations 4 and 5."""
    total = mi.Color3f(0.0)
    index = mi.UInt32(0)
    count = dr.opaque(mi.UInt32, samples)
    while dr.hint(index < count, exclude=[hit, light, active]):
        total += light_point(hit, light, sample_light(light, sampler, active), active)
        index += 1
    return total / samples


@dr.syntax
def ambient_light(
    scene: Any, entities: Entities, hit: Hit, samples: int, sampler: Any, active: Any
) -> Any:
    """Mean light of the surfaces around ``hit``, equation 6 without its factor k_a."""
    total = mi.Color3f(0.0)
    index = mi.UInt32(0)
    count = dr.opaque(mi.UInt32, samples)
    while dr.hint(index < count, exclude=[scene, entities, hit, active]):
        total += ambient_sample(scene, entities, hit, sampler, active)
        index += 1
    return total / samples


def ambient_sample(scene: Any, entities: Entities, hit: Hit, sampler: Any, active: Any) -> Any:
    """Light of the surface that one ray, uniform on the hemisphere about N, arrives at."""
    local = mi.warp.square_to_uniform_hemisphere(sampler.next_2d(active))
    direction = mi.Frame3f(hit.N).to_world(local)
    active = active & (dr.dot(direction, hit.N_g) > 0.0)
    si = scene.ray_intersect(hit.si.spawn_ray(direction), active)
    active &= si.is_valid()
    other = read_hit(si, direction, entities, active)
    total = mi.Color3f(0.0)
    for light in entities.lights:
        total += light_point(other, light, mi.Point3f(light.centroid), active)
    return total


def fresnel(cosine: Any, eta: Any) -> tuple[Any, Any]:
    """Unpolarised reflectance of a smooth dielectric, and the cosine of the refracted ray squared.

    ``eta`` is the index on the side of the ray over that on the far side; a negative square means
    total internal reflection, and reflectance 1.
    """
    k = 1.0 - dr.square(eta) * (1.0 - dr.square(cosine))
    refracted = dr.safe_sqrt(k)
    perpendicular = (eta * cosine - refracted) / (eta * cosine + refracted)
    parallel = (cosine - eta * refracted) / (cosine + eta * refracted)
    reflectance = 0.5 * (dr.square(perpendicular) + dr.square(parallel))
    reflectance = dr.select(eta == 1.0, 0.0, reflectance)
    return dr.select(k < 0.0, 1.0, reflectance), k


def follow_child(hit: Hit, entities: Entities, sampler: Any, active: Any) -> tuple[Any, Any]:
    """Direction of one child of the hit, and the factor of its contribution (equation 9).

    The factor is 0 where the surface neither mirrors nor refracts.
    """
    reflection = dr.gather(mi.Float, entities.reflection, hit.identity, active)
    transmission = dr.gather(mi.Float, entities.transmission, hit.identity, active)
    ior = dr.gather(mi.Float, entities.ior, hit.identity, active)
    by_fresnel = dr.gather(mi.Float, entities.fresnel, hit.identity, active) > 0.0
    eta = dr.select(hit.inside, ior, dr.rcp(ior))
    cosine = dr.maximum(dr.dot(hit.N, hit.V), 0.0)
    reflectance, k = fresnel(cosine, eta)
    mirror_weight = dr.select(by_fresnel, reflectance, reflection)
    refraction_weight = dr.select(by_fresnel, 1.0 - reflectance, transmission)
    refraction_weight = dr.select(k < 0.0, 0.0, refraction_weight)
    weight = mirror_weight + refraction_weight
    mirrors = sampler.next_1d(active) * weight < mirror_weight
    mirrored = 2.0 * dr.dot(hit.N, hit.V) * hit.N - hit.V
    refracted = (eta * cosine - dr.safe_sqrt(k)) * hit.N - eta * hit.V
    direction = dr.normalize(dr.select(mirrors, mirrored, refracted))
    return direction, dr.select(active, weight, 0.0)


def shade(
    scene: Any, entities: Entities, settings: ModelSettings, hit: Hit, sampler: Any, active: Any
) -> Any:
    """Light that leaves the hit towards the viewer, equation 1, without its children's."""
    light = dr.gather(mi.Color3f, entities.radiance, hit.identity, active)
    for source in entities.lights:
        if settings.light_samples == 0:
            light += light_point(hit, source, mi.Point3f(source.centroid), active)
        else:
            light += direct_light(hit, source, settings.light_samples, sampler, active)
    k_a = dr.gather(mi.Color3f, entities.ambient, hit.identity, active)
    if settings.ambient is not None:
        return light + k_a * mi.Color3f(settings.ambient)
    gathers = active & (dr.max(k_a) > 0.0)
    return light + k_a * ambient_light(
        scene, entities, hit, settings.ambient_samples, sampler, gathers
    )


@dr.syntax
def trace(
    scene: Any, entities: Entities, settings: ModelSettings, sampler: Any, ray: Any, active: Any
) -> tuple[Any, Any]:
    """Radiance along camera rays and whether they hit anything."""
    ray = mi.Ray3f(ray)
    active = mi.Mask(active)
    result = mi.Color3f(0.0)
    contribution = mi.Float(1.0)
    layer = mi.UInt32(0)
    layers = dr.opaque(mi.UInt32, settings.max_layers)
    anything = mi.Mask(False)
    while dr.hint(active, exclude=[scene, entities, settings]):
        si = scene.ray_intersect(ray, active)
        active &= si.is_valid()
        anything |= active
        hit = read_hit(si, ray.d, entities, active)
        light = shade(scene, entities, settings, hit, sampler, active)
        result += dr.select(active, contribution * light, 0.0)
        direction, factor = follow_child(hit, entities, sampler, active)
        contribution *= factor
        layer += 1
        active &= (factor > 0.0) & (layer < layers)
        ray = si.spawn_ray(direction)
    return result, anything
