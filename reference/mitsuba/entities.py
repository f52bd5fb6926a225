"""What the integrators `haste` and `whitted` read from an instantiated Mitsuba scene.

Everything comes from the objects of the scene itself (their parameters, one object at a time), so
nothing here depends on the project's own importer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

Rgb = tuple[float, float, float]
BLACK: Rgb = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Constants:
    """Constants of one material, named as in docs/lighting.md."""

    diffuse: Rgb = BLACK
    specular: Rgb = BLACK
    ambient: Rgb = BLACK
    exponent: float = 1.0
    reflection: float = 0.0
    transmission: float = 0.0
    ior: float = 1.0
    fresnel: bool = False


@dataclass(frozen=True, slots=True)
class Light:
    """An emitting shape, and a scene of all other shapes, for its shadow rays."""

    shape: Any
    identity: int
    radiance: Rgb
    centroid: Rgb
    sphere: tuple[Rgb, float] | None
    others: Any | None


@dataclass(frozen=True, slots=True)
class Entities:
    """Materials by shape, as tables in Dr.Jit's memory, and the lights.

    The tables are indexed with the number that Dr.Jit gives a shape (`shape_identity`).
    """

    diffuse: Any
    specular: Any
    ambient: Any
    exponent: Any
    reflection: Any
    transmission: Any
    ior: Any
    fresnel: Any
    radiance: Any
    lights: tuple[Light, ...]


def shape_identity(shape: Any) -> Any:
    """Number of the shape that each lane points to; 0 is no shape."""
    return dr.reinterpret_array(mi.UInt32, shape)


def _values(parameters: Any) -> dict[str, tuple[float, ...]]:
    return {
        key: tuple(float(x) for x in np.asarray(value, dtype=np.float64).reshape(-1))
        for key, value in parameters
    }


def _rgb(value: tuple[float, ...], what: str) -> Rgb:
    if len(value) == 1:
        return (value[0],) * 3
    if len(value) != 3:
        raise ValueError(f"{what} must be constant, not a texture")
    return (value[0], value[1], value[2])


def _label(shape: Any) -> str:
    return f'shape "{shape.id()}" ({shape.class_name()})'


def material_constants(bsdf: Any, where: str) -> Constants:
    """Constants of a BSDF.

    Raises
    ------
    ValueError
        If the models `haste` and `whitted` give the BSDF no meaning.
    """
    values = _values(mi.traverse(bsdf))
    kind = bsdf.class_name()
    if kind == "TwoSidedBRDF":
        if any(key.startswith("brdf_1.") for key in values):
            raise ValueError(f"{where}: twosided with two materials")
        values = {key.removeprefix("brdf_0."): value for key, value in values.items()}
    if "ambient_reflectance" in values:
        return Constants(
            diffuse=_rgb(values["diffuse_reflectance"], where),
            specular=_rgb(values["specular_reflectance"], where),
            ambient=_rgb(values["ambient_reflectance"], where),
            exponent=values["exponent"][0],
            reflection=values["reflection"][0],
            transmission=values["transmission"][0],
            ior=values["int_ior"][0],
        )
    tints = [key for key in values if key.startswith("specular_") and set(values[key]) != {1.0}]
    if tints:
        raise ValueError(f"{where}: {', '.join(tints)} other than 1")
    if kind in ("SmoothDiffuse", "TwoSidedBRDF") and "reflectance.value" in values:
        diffuse = _rgb(values["reflectance.value"], where)
        return Constants(diffuse=diffuse, ambient=diffuse)
    if _is_ideal_mirror(values):
        return Constants(reflection=1.0)
    if kind == "SmoothDielectric":
        return Constants(ior=values["eta"][0], fresnel=True)
    raise ValueError(f"{where}: a {kind} is no material of the models haste and whitted")


def _is_ideal_mirror(values: dict[str, tuple[float, ...]]) -> bool:
    """Mitsuba's conductor of material `none`."""
    return set(values.get("eta.value", ())) == {0.0} and set(values.get("k.value", ())) == {1.0}


def _mesh_centroid(shape: Any) -> Rgb:
    """Centroid of a mesh's triangles, weighted with their areas."""
    vertices = np.asarray(shape.vertex_positions_buffer(), dtype=np.float64).reshape(-1, 3)
    corners = vertices[np.asarray(shape.faces_buffer(), dtype=np.int64).reshape(-1, 3)]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    centroid = (area[:, None] * corners.mean(axis=1)).sum(axis=0) / area.sum()
    return (float(centroid[0]), float(centroid[1]), float(centroid[2]))


def _to_world(shape: Any) -> NDArray[np.float64]:
    """The 4 x 4 matrix of a shape that is no mesh."""
    return np.asarray(mi.traverse(shape)["to_world"].matrix, dtype=np.float64).reshape(4, 4)


def _sphere(shape: Any, where: str) -> tuple[Rgb, float]:
    to_world = _to_world(shape)
    linear = to_world[:3, :3]
    scale = np.cbrt(abs(np.linalg.det(linear)))
    if not np.allclose(linear.T @ linear, scale**2 * np.eye(3), rtol=0.0, atol=1e-4 * scale**2):
        raise ValueError(f"{where}: a sphere may only be scaled uniformly")
    return (float(to_world[0, 3]), float(to_world[1, 3]), float(to_world[2, 3])), float(scale)


def _light(shapes: list[Any], index: int) -> Light:
    shape = shapes[index]
    where = _label(shape)
    emitter = shape.emitter()
    values = _values(mi.traverse(emitter))
    if emitter.class_name() != "AreaLight" or len(values.get("radiance.value", ())) not in (1, 3):
        raise ValueError(f"{where}: its emitter must be `area` with a constant radiance")
    if shape.is_mesh():
        sphere, centroid = None, _mesh_centroid(shape)
    elif shape.class_name() == "Sphere":
        sphere = _sphere(shape, where)
        centroid = sphere[0]
    elif shape.class_name() == "Disk":
        x, y, z = (float(value) for value in _to_world(shape)[:3, 3])
        sphere, centroid = None, (x, y, z)
    else:
        raise ValueError(
            f"{where}: only meshes, disks and spheres emit in the models haste and whitted"
        )
    others = {f"other_{k}": other for k, other in enumerate(shapes) if k != index}
    return Light(
        shape=shape,
        identity=int(shape_identity(mi.ShapePtr(shape))[0]),
        radiance=_rgb(values["radiance.value"], where),
        centroid=centroid,
        sphere=sphere,
        others=_occluders(others),
    )


def _occluders(shapes: dict[str, Any]) -> Any | None:
    if not shapes:
        return None
    return mi.load_dict({"type": "scene", "embree_use_robust_intersections": True, **shapes})


def read_entities(scene: Any) -> Entities:
    """Materials and lights of ``scene``.

    Raises
    ------
    ValueError
        For an emitter or a material that the models `haste` and `whitted` do not know; the message
        names the shape.
    """
    shapes = list(scene.shapes())
    for emitter in scene.emitters():
        if emitter.class_name() != "AreaLight":
            raise ValueError(
                f'emitter "{emitter.id()}" ({emitter.class_name()}): the models haste and whitted '
                "know no lights but shapes with an area emitter"
            )
    identities = [int(shape_identity(mi.ShapePtr(shape))[0]) for shape in shapes]
    rows = [Constants()] * (max(identities, default=0) + 1)
    radiance = [BLACK] * len(rows)
    lights = tuple(_light(shapes, k) for k, shape in enumerate(shapes) if shape.is_emitter())
    for identity, shape in zip(identities, shapes, strict=True):
        rows[identity] = material_constants(shape.bsdf(), _label(shape))
    for light in lights:
        radiance[light.identity] = light.radiance
    return Entities(
        diffuse=_colours([row.diffuse for row in rows]),
        specular=_colours([row.specular for row in rows]),
        ambient=_colours([row.ambient for row in rows]),
        exponent=_floats([row.exponent for row in rows]),
        reflection=_floats([row.reflection for row in rows]),
        transmission=_floats([row.transmission for row in rows]),
        ior=_floats([row.ior for row in rows]),
        fresnel=_floats([float(row.fresnel) for row in rows]),
        radiance=_colours(radiance),
        lights=lights,
    )


def _floats(values: list[float]) -> Any:
    return mi.Float(np.asarray(values, dtype=np.float32))


def _colours(values: list[Rgb]) -> Any:
    return mi.Float(np.asarray(values, dtype=np.float32).reshape(-1))
