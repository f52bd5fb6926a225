"""A scene as plain records and arrays: what every tracer is given."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from harness.scene.dead_weight import Dropped
from harness.scene.features import Features

Rgb = tuple[float, float, float]
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Material:
    """A BSDF in the vocabulary of docs/lighting.md.

    kind "phong" uses diffuse (k_d i_d), specular (k_s i_s), ambient (k_a), exponent (alpha),
    reflection and transmission (R); kind "dielectric" is smooth glass and uses `ior` alone. `ior`
    is the index inside over the index outside. Mitsuba's `diffuse` is phong with diffuse and
    ambient alone, its `conductor` of material `none` is phong with reflection 1, and a light
    without a BSDF is phong with everything 0.
    """

    name: str
    kind: Literal["phong", "dielectric"]
    diffuse: Rgb = (0.0, 0.0, 0.0)
    specular: Rgb = (0.0, 0.0, 0.0)
    ambient: Rgb = (0.0, 0.0, 0.0)
    exponent: float = 30.0
    reflection: float = 0.0
    transmission: float = 0.0
    ior: float = 1.5
    twosided: bool = False
    location: str = ""


@dataclass(frozen=True, slots=True)
class Shape:
    """A triangle mesh or a sphere.

    material: index into `Scene.materials`. light: index into `Scene.lights`, -1 for none. mesh:
    triangles first .. first + count - 1. sphere: index `first` into `Scene.spheres`, count 1.
    smooth: the mesh has vertex normals that differ from those of its faces. flip_normals: spheres
    only, the normal points inwards; a mesh has its flip baked into winding and normals. location:
    "file (line, col)" of the shape in its scene.
    """

    name: str
    kind: Literal["mesh", "sphere"]
    material: int
    light: int
    first: int
    count: int
    smooth: bool
    flip_normals: bool
    location: str


@dataclass(frozen=True, slots=True)
class Light:
    """An emitting shape: index into `Scene.shapes`, and its radiance in linear sRGB."""

    shape: int
    radiance: Rgb


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera in world space, float64.

    The direction through the film position (x, y), in pixels with y down, is corner + x * dx + y *
    dy; its component along the view axis is 1. A ray starts at origin + near * direction, and only
    then is the direction normalised: rays start on the near plane.
    """

    origin: Vector
    corner: Vector
    dx: Vector
    dy: Vector
    near: float
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene in world space. Arrays are C-contiguous.

    vertices float32 [V, 3]; normals float32 [V, 3], zeros where the shape is not smooth; triangles
    uint32 [T, 3] into vertices; triangle_shape uint32 [T]; spheres float32 [S, 4] (centre, radius);
    sphere_shape uint32 [S]. `environment` is the radiance of a constant environment. `sha256` is
    the hash of the scene's XML and of every file that it refers to, and does not depend on where
    they lie. `dropped` is what import left out; `dropped_triangles` are the numbers of the
    triangles among it, uint32, ascending, by their shape.
    """

    name: str
    path: str
    shapes: list[Shape]
    materials: list[Material]
    lights: list[Light]
    camera: Camera
    environment: Rgb | None
    vertices: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.uint32]
    triangle_shape: npt.NDArray[np.uint32]
    spheres: npt.NDArray[np.float32]
    sphere_shape: npt.NDArray[np.uint32]
    features: Features
    sha256: str
    dropped: tuple[Dropped, ...]
    dropped_triangles: Mapping[int, npt.NDArray[np.uint32]]
