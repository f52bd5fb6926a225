"""Mitsuba's parser, wrapped: a file or dictionary in, a checked and normalised parser state out."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.scene.checks import check_state
from harness.scene.errors import SceneError
from harness.scene.generated import generated_in
from harness.scene.nodes import Problems, children, children_of_type, reachable
from harness.scene.recentre import recentre_state
from harness.scene.variant import active_variant, mitsuba_errors, parser_config

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode

SceneSource = str | os.PathLike[str] | Mapping[str, Any]

# Marks a dictionary's `phong` while Mitsuba's parser, which looks plugins up by name, reads it
# as `diffuse`.
_PHONG_MARK = "_haste_phong"


def scene_name(source: SceneSource) -> str:
    """What error messages call a scene: its path, or "dictionary scene"."""
    return "dictionary scene" if isinstance(source, Mapping) else os.fspath(source)


def scene_file(source: str | os.PathLike[str]) -> Path:
    """The XML file that `source`, a scene folder or an XML file, stands for."""
    path = Path(source)
    file = path / "scene.xml" if path.is_dir() else path
    if not file.is_file():
        raise SceneError(os.fspath(source), [f"no such scene: {file} does not exist"])
    return file


def read_state(
    source: SceneSource, variant: str, parameters: Mapping[str, str] | None = None
) -> "ParserState":
    """Parse a scene and resolve its references; nothing in it is judged or changed.

    Raises `SceneError` where Mitsuba's parser cannot read it.
    """
    import mitsuba as mi

    name = scene_name(source)
    with active_variant(variant), mitsuba_errors(name):
        config = parser_config(variant)
        if isinstance(source, Mapping):
            state = mi.parser.parse_dict(config, _without_phong(source))
            _restore_phong(state)
        else:
            file = scene_file(source).resolve()
            _check_generated(name, file)
            state = mi.parser.parse_file(config, os.fspath(file), **(parameters or {}))
        mi.parser.transform_all(config, state)
    return state


def parse_scene(
    source: SceneSource,
    variant: str,
    *,
    width: int | None = None,
    height: int | None = None,
    integrator: Mapping[str, Any] | None = None,
    recentre: bool = False,
    parameters: Mapping[str, str] | None = None,
) -> "ParserState":
    """Parse a scene folder, XML file or Mitsuba dictionary into a parser state for `variant`.

    In the state that is returned references are resolved, files have absolute paths, and what would
    let tracers differ is fixed: box filter, float32 rgb film of width x height pixels (None keeps
    the scene's own size; a crop window is scaled with it), `independent` sampler, robust
    intersections, and the integrator `integrator` (a flat dictionary with "type"; None keeps the
    scene's own). The state may go through `mi.parser.transform_all` (once more does no harm) and
    `mi.parser.instantiate`.

    `recentre` moves shapes and sensor by minus the centre of the scene's bounding box, in double
    precision. `parameters` are values for the `<default>` parameters of a file, as after Mitsuba's
    own option -D.

    Raises `SceneError`, naming everything in the scene that is not supported and where it stands.
    """
    name = scene_name(source)
    with active_variant(variant), mitsuba_errors(name):
        state = read_state(source, variant, parameters)
        problems = Problems(state)
        _resolve_files(state, problems)
        check_state(state, problems)
        if not problems.lines:
            _force_sensor(state, width, height, problems)
        if problems.lines:
            raise SceneError(name, problems.lines)
        state.nodes[0].props["embree_use_robust_intersections"] = True
        if integrator is not None:
            _force_integrator(state, integrator)
        if recentre:
            recentre_state(state, problems)
        if problems.lines:
            raise SceneError(name, problems.lines)
    return state


def _check_generated(name: str, file: Path) -> None:
    """Refuse a shipped scene whose generated files are not there, naming the command that helps.

    A missing file that the scene includes would end Mitsuba's parser with a message of its own.
    """
    scene = generated_in(file.parent)
    if scene is not None and scene.missing:
        command = f"python -m harness generate --scene {scene.name}"
        lines = [f'file not found: "{part}" (made by: {command})' for part in scene.missing]
        raise SceneError(name, lines)


def _without_phong(value: Any) -> Any:
    """Copy of a scene dictionary with each `phong` renamed to `diffuse` and marked."""
    if not isinstance(value, Mapping):
        return value
    copy = {key: _without_phong(item) for key, item in value.items()}
    if copy.get("type") == "phong":
        copy |= {"type": "diffuse", _PHONG_MARK: True}
    return copy


def _restore_phong(state: "ParserState") -> None:
    for node in state.nodes:
        if _PHONG_MARK in node.props:
            node.props.set_plugin_name("phong")
            del node.props[_PHONG_MARK]


def _resolve_files(state: "ParserState", problems: Problems) -> None:
    """Make each "filename" absolute: relative to its XML file, the scene's, or a <path>."""
    import mitsuba as mi

    for index in reachable(state):
        node = state.nodes[index]
        if "filename" not in node.props:
            continue
        written = str(node.props["filename"])
        files = [Path(str(file)) for file in state.files]
        folders = [files[i].parent for i in (node.file_index, 0) if i < len(files)]
        candidates = [folder / written for folder in folders]
        candidates.append(Path(str(mi.file_resolver().resolve(written))))
        found = next((path.resolve() for path in candidates if path.is_file()), None)
        if found is None:
            problems.add(node, f'file not found: "{written}"')
        else:
            node.props["filename"] = os.fspath(found)


def _append(state: "ParserState", owner: "SceneNode", type_name: str, properties: Any) -> None:
    """Append a node that stands where `owner` stands.

    Appending may move the nodes in memory: no node taken from the state before is valid after.
    """
    import mitsuba as mi

    node = mi.parser.SceneNode()
    node.type = getattr(mi.ObjectType, type_name)
    node.file_index, node.offset = owner.file_index, owner.offset
    node.props = properties
    state.nodes.append(node)


def _replace_child(
    state: "ParserState", owner_index: int, type_name: str, key: str, properties: Any
) -> None:
    """Give a node exactly one child of a type, made of `properties`."""
    import mitsuba as mi

    owner = state.nodes[owner_index]
    for child_key, child in children(owner):
        if state.nodes[child].type == getattr(mi.ObjectType, type_name):
            del owner.props[child_key]
    _append(state, owner, type_name, properties)
    reference = mi.Properties.ResolvedReference(len(state.nodes) - 1)
    state.nodes[owner_index].props[key] = reference


def _force_integrator(state: "ParserState", integrator: Mapping[str, Any]) -> None:
    import mitsuba as mi

    properties = mi.Properties(str(integrator["type"]))
    for key, value in integrator.items():
        if key != "type":
            properties[key] = value
    _replace_child(state, 0, "Integrator", "_haste_integrator", properties)


def _force_sensor(
    state: "ParserState", width: int | None, height: int | None, problems: Problems
) -> None:
    """Replace the sensor's film and sampler; see `parse_scene`."""
    import mitsuba as mi

    sensor = children_of_type(state, state.nodes[0], "Sensor")[0]
    films = children_of_type(state, state.nodes[sensor], "Film")
    written = state.nodes[films[0]] if films else state.nodes[sensor]
    window = film_window(written, width, height, problems)
    properties = mi.Properties("hdrfilm")
    for key, value in window.items():
        properties[key] = value
    properties["pixel_format"] = "rgb"
    properties["component_format"] = "float32"
    _append(state, written, "ReconstructionFilter", mi.Properties("box"))
    properties["_haste_filter"] = mi.Properties.ResolvedReference(len(state.nodes) - 1)
    _replace_child(state, sensor, "Film", "_haste_film", properties)
    _replace_child(state, sensor, "Sampler", "_haste_sampler", mi.Properties("independent"))


def film_window(
    film: "SceneNode", width: int | None, height: int | None, problems: Problems
) -> dict[str, int]:
    """Film size and crop window of a film node, scaled so that the window has width x height
    pixels.

    A scaled window must fall on whole pixels, else that is recorded as a problem.
    """
    props = film.props
    size = (int(props.get("width", 768)), int(props.get("height", 576)))
    crop_size = (int(props.get("crop_width", size[0])), int(props.get("crop_height", size[1])))
    crop_offset = (int(props.get("crop_offset_x", 0)), int(props.get("crop_offset_y", 0)))
    window: dict[str, int] = {}
    for axis, asked, letter, side in ((0, width, "x", "width"), (1, height, "y", "height")):
        inside = crop_size[axis] > 0 and crop_offset[axis] >= 0
        if not inside or crop_offset[axis] + crop_size[axis] > size[axis]:
            problems.add(film, f"the crop window leaves the film along {letter}")
            continue
        target = crop_size[axis] if asked is None else asked
        if target < 1:
            problems.add(film, f"{side} must be at least 1, not {target}")
            continue
        scaled = (size[axis] * target, crop_offset[axis] * target)
        if any(value % crop_size[axis] for value in scaled):
            problems.add(
                film, f"a crop window scaled to {side} {target} does not fall on whole pixels"
            )
            continue
        window[side] = scaled[0] // crop_size[axis]
        window[f"crop_{side}"] = target
        window[f"crop_offset_{letter}"] = scaled[1] // crop_size[axis]
    return window
