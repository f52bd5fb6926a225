"""Reading nodes of Mitsuba's parser: children, references, values, places."""

import math
import re
from bisect import bisect_right
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode


class Problems:
    """Everything wrong with a scene, gathered before anything is raised."""

    def __init__(self, state: "ParserState") -> None:
        self.state = state
        self.lines: list[str] = []

    def add(self, node: "SceneNode", text: str) -> None:
        """Record that `text` is wrong with `node`."""
        line = f"{describe(self.state, node)}: {text}"
        if line not in self.lines:
            self.lines.append(line)


def location(state: "ParserState", node: "SceneNode") -> str:
    """Where a node stands: "file (line 3, col 4)", or the path of keys in a dictionary scene."""
    import mitsuba as mi

    if node.file_index >= len(state.files):
        return str(mi.parser.file_location(state, node))
    # As `file_location` has it, which reads the file anew each time: too slow for 7,000 shapes.
    file = str(state.files[node.file_index])
    starts = _line_starts(file, Path(file).stat().st_mtime_ns)
    line = bisect_right(starts, node.offset)
    return f"{file} (line {line}, col {node.offset - starts[line - 1] + 1})"


@lru_cache(maxsize=16)
def _line_starts(file: str, modified: int) -> list[int]:
    """Offset in bytes of each line of a file; `modified`, its time, tells its versions apart."""
    del modified
    return [0, *(found.end() for found in re.finditer(rb"\n", Path(file).read_bytes()))]


def describe(state: "ParserState", node: "SceneNode") -> str:
    """Type, plugin, id and place of a node, as error messages give them."""
    kind = str(node.type).rpartition(".")[2].lower()
    name = f' (id "{node.props.id()}")' if node.props.id() else ""
    return f'{kind} "{node.props.plugin_name()}"{name} at {location(state, node)}'


def children(node: "SceneNode") -> list[tuple[str, int]]:
    """(property name, node index) of each child of a node, in file order, references resolved."""
    import mitsuba as mi

    resolved = mi.Properties.Type.ResolvedReference
    return [
        (key, node.props[key].index()) for key in node.props if node.props.type(key) == resolved
    ]


def children_of_type(state: "ParserState", node: "SceneNode", type_name: str) -> list[int]:
    """Indices of the children whose object type is `type_name` ("BSDF", "Emitter", ...)."""
    import mitsuba as mi

    wanted = getattr(mi.ObjectType, type_name)
    return [index for _, index in children(node) if state.nodes[index].type == wanted]


def reachable(state: "ParserState") -> list[int]:
    """Indices of the nodes that the scene uses, depth first from the root, each once."""
    order: list[int] = []
    seen: set[int] = set()
    stack = [0]
    while stack:
        index = stack.pop()
        if index in seen:
            continue
        seen.add(index)
        order.append(index)
        stack.extend(child for _, child in reversed(children(state.nodes[index])))
    return order


def colour(
    problems: Problems, node: "SceneNode", name: str, default: tuple[float, float, float]
) -> tuple[float, float, float]:
    """The linear sRGB value of property `name`, which may be written as rgb, number or uniform
    spectrum.

    Anything else (a texture, a spectrum over wavelengths) is recorded as a problem, and so is a
    value that is not finite or is negative; `default` is returned then.
    """
    import mitsuba as mi

    if name not in node.props:
        return default
    value: Any = node.props[name]
    kind = node.props.type(name)
    types = mi.Properties.Type
    if kind == types.ResolvedReference:
        texture = problems.state.nodes[value.index()]
        plugin = texture.props.plugin_name()
        if plugin not in ("uniform", "srgb") or "value" not in texture.props:
            problems.add(node, f'"{name}" is textured ("{plugin}"), not a constant colour')
            return default
        value, kind = texture.props["value"], texture.props.type("value")
    if kind in (types.Float, types.Integer):
        rgb = (float(value),) * 3
    elif kind in (types.Color, types.Vector):
        rgb = (float(value[0]), float(value[1]), float(value[2]))
    elif kind == types.Spectrum and value.is_uniform():
        rgb = (float(value.values()[0]),) * 3
    else:
        problems.add(node, f'"{name}" must be a colour, a number or a uniform spectrum')
        return default
    if not all(math.isfinite(channel) and channel >= 0.0 for channel in rgb):
        problems.add(node, f'"{name}" must be finite and not negative, not {rgb}')
        return default
    return rgb


def number(problems: Problems, node: "SceneNode", name: str, default: float) -> float:
    """The finite number in property `name`; anything else is recorded as a problem."""
    import mitsuba as mi

    if name not in node.props:
        return default
    kind = node.props.type(name)
    if kind not in (mi.Properties.Type.Float, mi.Properties.Type.Integer):
        problems.add(node, f'"{name}" must be a number')
        return default
    value = float(node.props[name])
    if not math.isfinite(value):
        problems.add(node, f'"{name}" must be finite, not {value}')
        return default
    return value
