"""A copy of somebody's Mitsuba scene that this benchmark can render.

The copy is edited as XML, not read and written by Mitsuba: comments and everything that is not
replaced stay as they are, and files that the scene refers to are still found from where the copy
lies.
"""

import argparse
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree as ET

import numpy as np

from harness.scene import Scene, SceneError, load_scene
from harness.scene.plugins import SUPPORTED
from harness.whole_files import written_whole

FOV = 40.0
"""Degrees, on both sides of the added camera's square film."""
DIRECTION = (0.5, -0.7, 0.5)
"""From the scene's centre to the added camera; the last one is along the axis that points up."""
EDGE = 512
"""Pixels along both sides of the added camera's film."""
REFLECTANCE = {
    "diffuse": "reflectance",
    "phong": "diffuse_reflectance",
    "twosided": "reflectance",
}
"""The parameter of a BSDF that NEW:0.8 sets; of twosided, that of the diffuse BSDF inside."""

Axis = Literal["x", "y", "z"]


def retarget(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    replace_bsdf: Mapping[str, str],
    emitter: float | None = None,
    camera: bool = False,
    up: Axis = "z",
) -> list[str]:
    """Write a copy of a Mitsuba file with other BSDFs, and with light and camera if asked for.

    replace_bsdf: types of BSDF and what takes their place, "diffuse" or, with a reflectance,
    "diffuse:0.8"; "twosided" is a diffuse one that reflects on both sides. The replaced BSDF keeps
    its id, and its parameters are dropped, as they mean nothing to another plugin. emitter:
    radiance of a constant environment, added if nothing in the scene emits. camera: add a
    perspective camera that sees all of the scene, if there is none. up: the axis that points up in
    its picture.

    Returns a line for each thing that was done or was not needed. Raises `SceneError` if the file
    cannot be read, a type is not in it, or the copy cannot be rendered still.
    """
    source, target = Path(source), Path(target)
    tree = _read(source)
    root = tree.getroot()
    if target.exists() and target.samefile(source):
        raise SceneError(os.fspath(target), ["the copy must not replace the scene itself"])
    done = [line for old, new in replace_bsdf.items() for line in _replace(root, old, new, source)]
    moved = _move_files(root, source.parent.resolve(), target.parent.resolve())
    if moved:
        done.append(f"{moved} references to files, relative to {target.parent.resolve()}")
    emitters = len(root.findall(".//emitter"))
    if emitter is not None and emitters:
        done.append(f"no emitter added: the scene has {emitters}")
    elif emitter is not None:
        root.append(_constant(emitter))
        done.append(f"a constant environment of radiance {emitter:g}")
    target.parent.mkdir(parents=True, exist_ok=True)
    sensors = len(root.findall(".//sensor"))
    if camera and sensors:
        done.append(f"no camera added: the scene has {sensors}")
    elif camera:
        done.append(_add_camera(tree, target, up))
    _write(tree, target)
    return [f"{target}: {line}" for line in done or ["nothing had to be changed"]]


def _read(source: Path) -> "ET.ElementTree[ET.Element]":
    if not source.is_file():
        raise SceneError(os.fspath(source), [f"no such scene: {source} does not exist"])
    parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))  # noqa: S314 - a local file
    try:
        tree = ET.parse(source, parser)  # noqa: S314 - a local file
    except ET.ParseError as error:
        raise SceneError(os.fspath(source), [f"not XML: {error}"]) from error
    if tree.getroot().tag != "scene":
        raise SceneError(os.fspath(source), ["the root must be a scene"])
    return tree


def _write(tree: "ET.ElementTree[ET.Element]", target: Path) -> None:
    ET.indent(tree, "    ")
    with written_whole(target) as (temporary,):
        tree.write(temporary, encoding="utf-8")


def _replace(root: ET.Element, old: str, new: str, source: Path) -> list[str]:
    kind, colon, value = new.partition(":")
    if kind not in SUPPORTED["BSDF"]:
        known = ", ".join(SUPPORTED["BSDF"])
        raise SceneError(os.fspath(source), [f'BSDF "{kind}" is not supported; {known} are'])
    if colon and (kind not in REFLECTANCE or not _is_number(value)):
        raise SceneError(os.fspath(source), [f'"{new}" is not of the form diffuse:0.8'])
    found = [node for node in root.iter("bsdf") if node.get("type") == old]
    if not found:
        raise SceneError(os.fspath(source), [f'no BSDF of the type "{old}" is in it'])
    for node in found:
        kept = {key: node.attrib[key] for key in ("id", "name") if key in node.attrib}
        tail = node.tail
        node.clear()
        node.attrib.update({"type": kind, **kept})
        node.tail = tail
        inner = ET.SubElement(node, "bsdf", {"type": "diffuse"}) if kind == "twosided" else node
        if colon:
            rgb = {"name": REFLECTANCE[kind], "value": f"{value}, {value}, {value}"}
            ET.SubElement(inner, "rgb", rgb)
    return [f'{len(found)} BSDFs "{old}" are "{new}" now']


def _is_number(text: str) -> bool:
    try:
        return 0.0 <= float(text) <= 1.0
    except ValueError:
        return False


def _move_files(root: ET.Element, old: Path, new: Path) -> int:
    """Make references to files, which start from `old`, start from `new`; returns how many."""
    moved = 0
    for node in root.iter():
        if node.tag == "string" and node.get("name") == "filename":
            key = "value"
        elif node.tag == "include":
            key = "filename"
        elif node.tag == "path":
            key = "value"
        else:
            continue
        written = node.get(key, "")
        if old == new or "$" in written or Path(written).is_absolute():
            continue
        node.set(key, Path(os.path.relpath(old / written, new)).as_posix())
        moved += 1
    return moved


def _constant(radiance: float) -> ET.Element:
    node = ET.Element("emitter", {"type": "constant"})
    ET.SubElement(node, "rgb", {"name": "radiance", "value": ", ".join([f"{radiance:g}"] * 3)})
    return node


def _add_camera(tree: "ET.ElementTree[ET.Element]", target: Path, up: Axis) -> str:
    """Add a camera that sees the sphere about the scene's bounding box.

    The scene is read as it is imported, so through a first copy with any camera at all.
    """
    root = tree.getroot()
    sensor = _sensor((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), up="x", near=1e-2, far=1e30)
    root.append(sensor)
    probe = target.with_name(f".{target.name}.probe.xml")
    _write(tree, probe)
    try:
        low, high = _bounds(load_scene(probe))
    except SceneError as error:
        problems = [
            problem.replace(os.fspath(probe.resolve()), "the copy") for problem in error.problems
        ]
        raise SceneError(os.fspath(target), problems) from error
    finally:
        probe.unlink()
    root.remove(sensor)
    centre, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    # The axis that points up takes the last place; the others follow in turn.
    turn = "xyz".index(up) + 1
    direction = np.roll(np.array(DIRECTION) / math.hypot(*DIRECTION), turn)
    distance = radius / math.sin(math.radians(0.5 * FOV))
    origin = centre + distance * direction
    root.append(_sensor(origin, centre, up=up, near=1e-3 * distance, far=2.0 * (distance + radius)))
    at = ", ".join(f"{value:.4g}" for value in origin)
    return f"a camera at ({at}), {up} up, that sees a scene of radius {radius:.4g}"


def _bounds(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner of a scene's bounding box, float64 [3]."""
    centres, radii = scene.spheres[:, :3].astype(np.float64), scene.spheres[:, 3:]
    points = np.concatenate([scene.vertices.astype(np.float64), centres - radii, centres + radii])
    return points.min(axis=0), points.max(axis=0)


def _sensor(origin: object, towards: object, *, up: Axis, near: float, far: float) -> ET.Element:
    node = ET.Element("sensor", {"type": "perspective"})
    for name, value in (("fov", FOV), ("near_clip", near), ("far_clip", far)):
        ET.SubElement(node, "float", {"name": name, "value": f"{value:g}"})
    transform = ET.SubElement(node, "transform", {"name": "to_world"})
    axes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    vectors = {"origin": origin, "target": towards, "up": axes[up]}
    texts = {key: ", ".join(f"{float(x):.9g}" for x in value) for key, value in vectors.items()}
    ET.SubElement(transform, "lookat", texts)
    film = ET.SubElement(node, "film", {"type": "hdrfilm"})
    for side in ("width", "height"):
        ET.SubElement(film, "integer", {"name": side, "value": str(EDGE)})
    return node


def _replacement(text: str) -> tuple[str, str]:
    old, equals, new = text.partition("=")
    if not (old and equals and new):
        raise argparse.ArgumentTypeError(f"{text} is not of the form OLD=NEW")
    return old, new


def _radiance(text: str) -> float:
    number = float(text)
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not positive and finite")
    return number


def add_command(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add ``retarget`` to the commands of ``python -m harness``."""
    text = "copy a Mitsuba scene, with plugins that are missing here replaced"
    command = commands.add_parser("retarget", help=text, description=text)
    command.add_argument("source", type=Path, metavar="IN.XML")
    command.add_argument("target", type=Path, metavar="OUT.XML")
    command.add_argument(
        "--replace-bsdf",
        type=_replacement,
        action="append",
        default=[],
        metavar="OLD=NEW",
        help="make each BSDF of the type OLD one of the type NEW with its defaults, or as NEW:0.8 "
        "with that reflectance; may be repeated",
    )
    command.add_argument(
        "--add-emitter",
        type=_radiance,
        nargs="?",
        const=1.0,
        metavar="RADIANCE",
        help="add a constant environment (default: 1) where nothing emits",
    )
    command.add_argument(
        "--add-camera",
        action="store_true",
        help="add a perspective camera that sees all of the scene where there is none",
    )
    command.add_argument(
        "--up", choices=("x", "y", "z"), default="z", help="axis that points up (default: z)"
    )


def run_command(options: argparse.Namespace) -> int:
    """Run ``retarget`` with the arguments of `add_command`; returns the exit code."""
    lines = retarget(
        options.source,
        options.target,
        replace_bsdf=dict(options.replace_bsdf),
        emitter=options.add_emitter,
        camera=options.add_camera,
        up=options.up,
    )
    print(*lines, sep="\n")
    return 0
