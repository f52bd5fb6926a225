"""From a scene's parser state to plain arrays."""

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.scene.camera import read_camera
from harness.scene.checks import MAX_PIXELS, too_large
from harness.scene.dead_weight import Dropped, unused_materials, weightless_lobes
from harness.scene.errors import SceneError
from harness.scene.features import compute_features
from harness.scene.geometry import Geometry, build_geometry
from harness.scene.materials import DEFAULT_MATERIAL, LIGHT_MATERIAL, read_material
from harness.scene.nodes import Problems, children_of_type, colour, describe, location, reachable
from harness.scene.parse import SceneSource, parse_scene, scene_file, scene_name
from harness.scene.records import Camera, Light, Material, Rgb, Scene, Shape
from harness.scene.variant import mitsuba_errors

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState


def load_scene(
    source: SceneSource,
    width: int | None = None,
    height: int | None = None,
    recentre: bool = False,
    parameters: Mapping[str, str] | None = None,
) -> Scene:
    """Read a scene folder (scenes/<name>), a Mitsuba XML file or a Mitsuba dictionary.

    width, height: pixels of the picture, the scene's own where None. recentre: move the scene's
    centre to the origin before coordinates are rounded to float32. Runs Mitsuba's variant
    scalar_rgb, so that no LLVM library and no GPU is needed.

    Raises `SceneError`, naming everything that is not supported or wrong, and where it stands.
    """
    # The integrator is not part of a scene, and one defined in Python would need another variant.
    state = parse_scene(
        source,
        "scalar_rgb",
        width=width,
        height=height,
        integrator={"type": "path"},
        recentre=recentre,
        parameters=parameters,
    )
    problems = Problems(state)
    with mitsuba_errors(scene_name(source)):
        geometry = build_geometry(state, problems)
    camera = read_camera(state)
    if camera.width * camera.height > MAX_PIXELS:
        sensor = children_of_type(state, state.nodes[0], "Sensor")[0]
        problems.add(state.nodes[sensor], too_large(camera.width, camera.height))
    _check_far_clip(state, geometry, camera, problems)
    if problems.lines:
        raise SceneError(scene_name(source), problems.lines)

    materials = _Materials(state)
    dropped = [*unused_materials(state), *geometry.dropped]
    shapes: list[Shape] = []
    lights: list[Light] = []
    for part in geometry.parts:
        node = state.nodes[part.node]
        name = node.props.id() or f"{node.props.plugin_name()}_{len(shapes)}"
        emitters = children_of_type(state, node, "Emitter")
        bsdfs = children_of_type(state, node, "BSDF")
        light = -1
        radiance = _radiance(state, emitters[0]) if emitters else None
        if radiance is not None and max(radiance) > 0.0:
            light = len(lights)
            lights.append(Light(shape=len(shapes), radiance=radiance))
        elif emitters:
            dropped.append(Dropped("black light", 1, describe(state, node)))
        shapes.append(
            Shape(
                name=name,
                kind="sphere" if part.kind == "sphere" else "mesh",
                material=materials.index(bsdfs[0] if bsdfs else None, name, light=bool(emitters)),
                light=light,
                first=part.first,
                count=part.count,
                smooth=part.smooth,
                flip_normals=part.flip_normals,
                location=location(state, node),
            )
        )
    environment = _environment(state, dropped)
    return Scene(
        name=_name(source),
        path="" if isinstance(source, Mapping) else os.fspath(source),
        shapes=shapes,
        materials=materials.found,
        lights=lights,
        camera=camera,
        environment=environment,
        vertices=geometry.vertices,
        normals=geometry.normals,
        triangles=geometry.triangles,
        triangle_shape=_owners(shapes, "mesh"),
        spheres=geometry.spheres,
        sphere_shape=_owners(shapes, "sphere"),
        features=compute_features(shapes, materials.found, lights, environment),
        sha256=_content_hash(source, state),
        dropped=(*dropped, *materials.dropped),
        dropped_triangles={
            index: part.degenerate
            for index, part in enumerate(geometry.parts)
            if part.degenerate.size
        },
    )


class _Materials:
    """Materials met so far: one for each BSDF node, however many shapes refer to it."""

    def __init__(self, state: "ParserState") -> None:
        self._state = state
        self._index: dict[int | str, int] = {}
        self.found: list[Material] = []
        self.dropped: list[Dropped] = []

    def index(self, node: int | None, shape_name: str, *, light: bool) -> int:
        key: int | str = node if node is not None else ("light" if light else "default")
        if key not in self._index:
            if node is not None:
                material = read_material(self._state, node, f"{shape_name}.bsdf")
                self.dropped += weightless_lobes(self._state, self._state.nodes[node], material)
            else:
                material = LIGHT_MATERIAL if light else DEFAULT_MATERIAL
            self._index[key] = len(self.found)
            self.found.append(material)
        return self._index[key]


def _radiance(state: "ParserState", index: int) -> Rgb:
    return colour(Problems(state), state.nodes[index], "radiance", (1.0, 1.0, 1.0))


def _environment(state: "ParserState", dropped: list[Dropped]) -> Rgb | None:
    """Radiance of the environment; a black one is none, and named among the dropped."""
    emitters = children_of_type(state, state.nodes[0], "Emitter")
    if not emitters:
        return None
    radiance = _radiance(state, emitters[0])
    if max(radiance) > 0.0:
        return radiance
    dropped.append(Dropped("black environment", 1, describe(state, state.nodes[emitters[0]])))
    return None


def _owners(shapes: list[Shape], kind: str) -> Any:
    """Shape index of each triangle or sphere, uint32."""
    owned = [(index, shape) for index, shape in enumerate(shapes) if shape.kind == kind]
    indices = np.array([index for index, _ in owned], np.uint32)
    return np.repeat(indices, [shape.count for _, shape in owned])


def _check_far_clip(
    state: "ParserState", geometry: Geometry, camera: Camera, problems: Problems
) -> None:
    """Refuse a far clip plane that the scene reaches: no tracer but Mitsuba would cut there."""
    sensor = state.nodes[children_of_type(state, state.nodes[0], "Sensor")[0]]
    far = float(sensor.props.get("far_clip", 1e4))
    centres, radii = geometry.spheres[:, :3], geometry.spheres[:, 3:]
    points = np.concatenate([geometry.vertices, centres - radii, centres + radii]).astype(float)
    if not len(points):
        return
    low, high = points.min(axis=0), points.max(axis=0)
    reach = np.maximum(np.abs(low - camera.origin), np.abs(high - camera.origin))
    if float(np.linalg.norm(reach)) > far:
        problems.add(sensor, f"far_clip {far:g} cuts into the scene")


def _name(source: SceneSource) -> str:
    if isinstance(source, Mapping):
        return "dictionary"
    file = scene_file(source).resolve()
    return file.parent.name if file.name == "scene.xml" else file.stem


def _content_hash(source: SceneSource, state: "ParserState") -> str:
    digest = hashlib.sha256()
    if isinstance(source, Mapping):
        digest.update(_canonical(source).encode())
    for file in dict.fromkeys(str(file) for file in state.files if str(file)):
        digest.update(Path(file).read_bytes())
    for index in reachable(state):
        props = state.nodes[index].props
        if "filename" in props:
            file = Path(str(props["filename"]))
            digest.update(file.name.encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _canonical(value: Any) -> str:
    """A dictionary scene as text that depends on nothing but its content."""
    if isinstance(value, Mapping):
        return "{" + ",".join(f"{key}:{_canonical(item)}" for key, item in value.items()) + "}"
    if hasattr(value, "matrix"):
        return repr(np.array(value.matrix, np.float64).tolist())
    if hasattr(value, "tolist"):
        return repr(value.tolist())
    return repr(value)
