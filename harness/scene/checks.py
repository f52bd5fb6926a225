"""What the tracers cannot render, found in the parser's state before anything is built."""

import math
from typing import TYPE_CHECKING

from harness.scene.errors import SceneError
from harness.scene.materials import check_bsdf
from harness.scene.nodes import Problems, children, children_of_type, colour, reachable
from harness.scene.plugins import MEDIA, plugin_status, refusal, type_name
from harness.scene.records import Scene

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode

ENERGY_LIMIT = 1.0 + 1e-6
MAX_PIXELS = 8192 * 8192
"""Pixels of the largest picture: the largest size that settings.yaml can name."""
MODELS = ("path", "haste", "whitted")


def check_state(state: "ParserState", problems: Problems) -> None:
    """Record everything in the scene that no tracer of this benchmark supports.

    Expects resolved references (`mi.parser.transform_all`).
    """
    import mitsuba as mi

    types = mi.ObjectType
    root = state.nodes[0]
    if root.type != types.Scene:
        problems.add(root, "the root must be a scene")
        return
    for index in reachable(state):
        node = state.nodes[index]
        objects = [key for key in node.props if node.props.type(key) == mi.Properties.Type.Object]
        if objects:
            problems.add(node, f"objects made beforehand are not supported: {', '.join(objects)}")
        if node.type == types.Shape:
            _check_shape(state, node, problems)
        elif node.type == types.Emitter:
            _check_emitter(node, problems)
        elif type_name(node) in (*MEDIA, "Unknown"):
            problems.add(node, refusal(type_name(node)))
    for index in _bsdfs(state):
        check_bsdf(state, state.nodes[index], problems)
    environments = [
        index
        for index in children_of_type(state, root, "Emitter")
        if state.nodes[index].props.plugin_name() == "constant"
    ]
    for index in environments[1:]:
        problems.add(state.nodes[index], "a scene has at most one environment")
    _check_sensor(state, root, problems)
    if not children_of_type(state, root, "Shape"):
        problems.add(root, "the scene has no shapes")


def _bsdfs(state: "ParserState") -> list[int]:
    """BSDFs that a shape or the scene holds directly, each once."""
    import mitsuba as mi

    found: dict[int, None] = {}
    for index in reachable(state):
        node = state.nodes[index]
        if node.type in (mi.ObjectType.Shape, mi.ObjectType.Scene):
            found |= dict.fromkeys(children_of_type(state, node, "BSDF"))
    return list(found)


def _check_shape(state: "ParserState", node: "SceneNode", problems: Problems) -> None:
    import mitsuba as mi

    plugin = node.props.plugin_name()
    if plugin_status(node) == "missing":
        problems.add(node, refusal("Shape"))
        return
    if plugin in ("ply", "obj") and "filename" not in node.props:
        problems.add(node, 'the parameter "filename" is missing')
    if len(children_of_type(state, node, "BSDF")) > 1:
        problems.add(node, "a shape has at most one BSDF")
    if len(children_of_type(state, node, "Emitter")) > 1:
        problems.add(node, "a shape has at most one emitter")
    for _, child in children(node):
        held = state.nodes[child]
        if held.type == mi.ObjectType.Emitter and held.props.plugin_name() == "constant":
            problems.add(held, "an environment cannot belong to a shape")
        if held.type in (mi.ObjectType.Shape, mi.ObjectType.Sensor):
            problems.add(held, "cannot belong to a shape")
    if "to_world" in node.props and not _finite(node.props["to_world"].matrix):
        problems.add(node, '"to_world" is not finite')


def _check_emitter(node: "SceneNode", problems: Problems) -> None:
    plugin = node.props.plugin_name()
    if plugin_status(node) == "missing":
        problems.add(node, refusal("Emitter"))
        return
    for key in node.props:
        if key != "radiance":
            problems.add(node, f'unknown parameter "{key}" of {plugin}')
    colour(problems, node, "radiance", (1.0, 1.0, 1.0))


def _check_sensor(state: "ParserState", root: "SceneNode", problems: Problems) -> None:
    sensors = children_of_type(state, root, "Sensor")
    if not sensors:
        problems.add(root, "the scene has no sensor")
    for index in sensors[1:]:
        problems.add(state.nodes[index], "a scene has exactly one sensor")
    for index in sensors:
        node = state.nodes[index]
        if plugin_status(node) == "missing":
            problems.add(node, refusal("Sensor"))
        elif "to_world" in node.props and not _finite(node.props["to_world"].matrix):
            problems.add(node, '"to_world" is not finite')
        for film in children_of_type(state, node, "Film"):
            _check_film(state.nodes[film], problems)


def _check_film(node: "SceneNode", problems: Problems) -> None:
    import mitsuba as mi

    if plugin_status(node) == "missing":
        problems.add(node, refusal("Film"))
        return
    size = []
    for side, default in (("width", 768), ("height", 576)):
        if side not in node.props:
            size.append(default)
        elif node.props.type(side) != mi.Properties.Type.Integer:
            problems.add(node, f'"{side}" must be an integer')
        elif int(node.props[side]) < 1:
            problems.add(node, f'"{side}" must be at least 1, not {int(node.props[side])}')
        else:
            size.append(int(node.props[side]))
    if len(size) == 2 and math.prod(size) > MAX_PIXELS:
        problems.add(node, too_large(*size))


def too_large(width: int, height: int) -> str:
    """What is said of a picture of more than `MAX_PIXELS` pixels."""
    return f"{width} x {height} are {width * height} pixels, more than the {MAX_PIXELS} supported"


def _finite(matrix: "mi.ScalarMatrix4d") -> bool:
    return all(math.isfinite(float(matrix[i, j])) for i in range(4) for j in range(4))


def check_model(scene: Scene, model: str) -> None:
    """Raise `SceneError` if `scene` cannot be rendered with `model`: "path", "haste" or "whitted".

    Something must emit light; `haste` and `whitted` know no lights but emitting shapes. `path`
    demands that no material reflects and transmits more than it receives: max over channels of
    k_d + k_s + reflection + transmission <= 1.
    """
    problems = []
    if model not in MODELS:
        problems.append(f'unknown model "{model}"; known are {", ".join(MODELS)}')
    if model in ("haste", "whitted") and scene.environment is not None:
        problems.append(f"an environment has no meaning in the model {model}")
    lit = any(max(light.radiance) > 0.0 for light in scene.lights)
    if model in ("haste", "whitted") and not lit:
        problems.append(f"no shape emits light, so that a picture of the model {model} is black")
    if model == "path" and not lit and not max(scene.environment or (0.0,)) > 0.0:
        problems.append("nothing emits light, so that a picture of the model path is black")
    if model == "path":
        for material in scene.materials:
            albedo = max(map(sum, zip(material.diffuse, material.specular, strict=True)))
            energy = albedo + material.reflection + material.transmission
            if material.kind == "phong" and energy > ENERGY_LIMIT:
                problems.append(
                    f'material "{material.name}" at {material.location}: diffuse + specular + '
                    f"reflection + transmission = {energy:.6g} > 1, which the model path refuses"
                )
    if problems:
        raise SceneError(scene.name, problems)
