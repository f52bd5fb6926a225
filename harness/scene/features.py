"""What a scene requires of a tracer."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.scene.records import Light, Material, Shape


@dataclass(frozen=True, slots=True)
class Features:
    """True where a scene needs the named part of a tracer; CUDA kernels have these parts only."""

    triangles: bool = False
    spheres: bool = False
    smooth_normals: bool = False
    mesh_lights: bool = False
    sphere_lights: bool = False
    specular: bool = False
    mirror: bool = False
    transmission: bool = False
    dielectric: bool = False
    twosided: bool = False
    ambient: bool = False
    environment: bool = False
    diffuse: bool = False
    several_lights: bool = False

    def names(self) -> tuple[str, ...]:
        """Names of the features that are true, in the order in which they are declared."""
        return tuple(field.name for field in fields(self) if getattr(self, field.name))


def compute_features(
    shapes: "Sequence[Shape]",
    materials: "Sequence[Material]",
    lights: "Sequence[Light]",
    environment: tuple[float, float, float] | None,
) -> Features:
    """Features of the scene that these records make up.

    Only materials that a shape uses count, and nothing of a shape that is empty. `ambient` means
    that some material's k_a is not black, so that the models of the paper have ambient rays to
    trace; the environment is one of `several_lights`.
    """
    used = [materials[index] for index in {shape.material for shape in shapes if shape.count > 0}]
    phong = [material for material in used if material.kind == "phong"]
    light_kinds = {shapes[light.shape].kind for light in lights}
    return Features(
        triangles=any(shape.kind == "mesh" and shape.count > 0 for shape in shapes),
        spheres=any(shape.kind == "sphere" for shape in shapes),
        smooth_normals=any(shape.smooth and shape.count > 0 for shape in shapes),
        mesh_lights="mesh" in light_kinds,
        sphere_lights="sphere" in light_kinds,
        specular=any(max(material.specular) > 0.0 for material in phong),
        mirror=any(material.reflection > 0.0 for material in phong),
        transmission=any(material.transmission > 0.0 for material in phong),
        dielectric=any(material.kind == "dielectric" for material in used),
        twosided=any(material.twosided for material in used),
        ambient=any(max(material.ambient) > 0.0 for material in phong),
        environment=environment is not None,
        diffuse=any(max(material.diffuse) > 0.0 for material in phong),
        several_lights=len(lights) + (environment is not None) > 1,
    )
