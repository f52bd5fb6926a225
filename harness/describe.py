"""What a scene requires, and what of it is supported, missing or replaced: ``./bench features``."""

import os
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from harness.scene import (
    Scene,
    SceneError,
    Settings,
    check_model,
    load_scene,
    load_settings,
)
from harness.scene.checks import MODELS
from harness.scene.nodes import describe, location, reachable
from harness.scene.parse import SceneSource, read_state, scene_name
from harness.scene.plugins import REPLACED, Status, plugin_status, refusal, type_name
from harness.scene.settings import Model

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode

LABELS = {"ReconstructionFilter": "rfilter", "PhaseFunction": "phase", "Unknown": "plugin"}
"""Mitsuba's own words for types of objects, where they are not the type's name."""
FILM_FORMAT = ("file_format", "pixel_format", "component_format", "sample_border")
PLACES = 4
"""Places of a plugin that are printed where it is not missing."""


@dataclass(frozen=True, slots=True)
class Plugin:
    """One use of a plugin.

    kind: Mitsuba's type of object ("Shape", "BSDF", ...). status: "supported", "missing", or
    "ignored", which means replaced. place: "file (line 3, col 4)", or the keys of a dictionary.
    note: what replaces it, or why it is missing. line: its line among the problems of a refusal.
    """

    kind: str
    name: str
    id: str
    place: str
    status: Status
    note: str
    line: str


@dataclass(frozen=True, slots=True)
class Description:
    """What is known of a scene, be it accepted or refused.

    file: the XML file, "" for a dictionary. scene: None where the scene is refused. problems: why.
    models: by each model, why it cannot render the scene, "" where it can; empty where the scene is
    refused. settings: None where they are refused.
    """

    source: str
    file: str
    scene: Scene | None
    settings: Settings | None
    plugins: tuple[Plugin, ...]
    problems: tuple[str, ...]
    models: Mapping[Model, str]

    @property
    def missing(self) -> tuple[Plugin, ...]:
        """Uses of plugins that no tracer here understands."""
        return tuple(plugin for plugin in self.plugins if plugin.status == "missing")

    def reasons(self, models: Collection[Model] = MODELS) -> tuple[str, ...]:
        """Why the scene, or one of `models` that its settings name, is refused; empty if not."""
        named = [] if self.settings is None else self.settings.models
        refusals = [
            f"the model {model}: {self.models[model]}"
            for model in named
            if model in models and self.models.get(model)
        ]
        return (*self.problems, *refusals)

    def accepted(self, models: Collection[Model] = MODELS) -> bool:
        """Whether the scene can be rendered in each of `models` that its settings name."""
        return not self.reasons(models)


def describe_scene(
    source: SceneSource, width: int | None = None, height: int | None = None
) -> Description:
    """Describe a scene folder, a Mitsuba XML file or a Mitsuba dictionary. Nothing is raised: what
    is wrong with the scene is part of the answer.

    width, height: pixels of the picture that is asked for, the scene's own where None.
    """
    problems: list[str] = []
    plugins: tuple[Plugin, ...] = ()
    settings: Settings | None = None
    scene: Scene | None = None
    try:
        settings = load_settings({} if isinstance(source, Mapping) else source)
    except SceneError as error:
        problems += [f"{error.source}: {problem}" for problem in error.problems]
    try:
        plugins = list_plugins(source)
        recentre = settings is not None and settings.recentre
        scene = load_scene(source, width=width, height=height, recentre=recentre)
    except SceneError as error:
        problems += [problem for problem in error.problems if problem not in problems]
    models: dict[Model, str] = {}
    for model in MODELS if scene is not None else ():
        try:
            check_model(scene, model)
            models[model] = ""
        except SceneError as error:
            models[model] = "; ".join(error.problems)
    return Description(
        source=scene_name(source),
        file=_file(source),
        scene=scene,
        settings=settings,
        plugins=plugins,
        problems=tuple(problems),
        models=models,
    )


def _file(source: SceneSource) -> str:
    if isinstance(source, Mapping):
        return ""
    path = Path(source)
    return os.fspath((path / "scene.xml" if path.is_dir() else path).resolve())


def list_plugins(source: SceneSource) -> tuple[Plugin, ...]:
    """Every use of a plugin in a scene, in the order of the file; raises `SceneError` where the
    file cannot be parsed.
    """
    state = read_state(source, "scalar_rgb")
    return tuple(
        _plugin(state, state.nodes[index])
        for index in reachable(state)
        if type_name(state.nodes[index]) != "Scene"
    )


def _plugin(state: "ParserState", node: "SceneNode") -> Plugin:
    kind, status = type_name(node), plugin_status(node)
    note = ""
    if status == "missing":
        note = refusal(kind)
    elif status == "ignored":
        note = f"replaced by {REPLACED[kind]}"
    elif kind == "Film":
        others = sorted(key for key in node.props if key in FILM_FORMAT)
        note = "pictures have the size of settings.yaml or of the run's settings"
        note += f"; {', '.join(others)} ignored: pictures are float32 RGB" if others else ""
    line = f"{describe(state, node)}: {note}" if status == "missing" else ""
    name = node.props.plugin_name()
    return Plugin(kind, name, node.props.id(), location(state, node), status, note, line)


def format_description(description: Description, *, every_place: bool = False) -> str:
    """Lines to be printed. every_place: list all places of a plugin, not the first ones only."""
    blocks = [description.source, *_summary(description)]
    groups: dict[tuple[Status, str, str, str], list[Plugin]] = defaultdict(list)
    for plugin in description.plugins:
        groups[plugin.status, plugin.kind, plugin.name, plugin.note].append(plugin)
    order: Sequence[Status] = ("missing", "ignored", "supported")
    for (status, kind, name, note), uses in sorted(
        groups.items(), key=lambda group: order.index(group[0][0])
    ):
        title = f'  {status:<10} {_label(kind)} "{name}"'
        title += f", {len(uses)} times" if len(uses) > 1 else ""
        blocks.append(title + (f": {note}" if note else ""))
        shown = uses if every_place or status == "missing" else uses[:PLACES]
        for plugin in shown:
            place = _short(plugin.place, description.file)
            identity = f'"{plugin.id}" at ' if plugin.id else "at "
            blocks.append(f"{'':13}{identity}{place}")
        if len(shown) < len(uses):
            blocks.append(f"{'':13}and {len(uses) - len(shown)} more")
    lines = {plugin.line for plugin in description.missing}
    others = [problem for problem in description.problems if problem not in lines]
    blocks += [f"  wrong      {problem}" for problem in others]
    return "\n".join([*blocks, _verdict(description)])


def _short(place: str, file: str) -> str:
    """A place as it is printed below the name of the file that it is in."""
    inside = place.removeprefix("dictionary node ").removeprefix(file).strip()
    return inside.strip("()") if inside.startswith("(") else inside


def _label(kind: str) -> str:
    return LABELS.get(kind, kind.lower())


def _summary(description: Description) -> list[str]:
    scene, settings = description.scene, description.settings
    lines = []
    if scene is not None:
        counts = (
            (len(scene.triangles), "triangle"),
            (len(scene.spheres), "sphere"),
            (len(scene.lights), "light"),
            (len(scene.shapes), "shape"),
            (len(scene.materials), "material"),
        )
        contents = [f"{count:,} {noun}{'' if count == 1 else 's'}" for count, noun in counts]
        contents += ["an environment"] if scene.environment is not None else []
        lines += [
            f"  requires   {', '.join(scene.features.names()) or 'nothing'}",
            f"  contains   {', '.join(contents)}",
        ]
        lines += [f"  dropped    {lost}" for lost in scene.dropped]
    if settings is not None:
        width, height = settings.resolution
        lines.append(
            f"  settings   {', '.join(settings.models)}; {width} x {height} pixels, "
            f"max_depth {settings.max_depth}, max_layers {settings.max_layers}"
        )
    for model, reason in description.models.items():
        named = settings is not None and model in settings.models
        text = f"not possible: {reason}" if reason else "rendered" if named else "possible"
        lines.append(f"  {model:<10} {text}")
    return lines


def _verdict(description: Description) -> str:
    if description.accepted():
        return "  can be rendered"
    names = {(plugin.kind, plugin.name) for plugin in description.missing}
    if names:
        kinds = ", ".join(f'{_label(kind)} "{name}"' for kind, name in sorted(names))
        return f"  cannot be rendered: missing {kinds}"
    if description.scene is None:
        return "  cannot be rendered"
    return "  cannot be rendered in every model that its settings name"
