"""World space geometry of a parser state: Mitsuba builds the shapes, this reads their buffers."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from harness.scene.camera import to_world_matrix
from harness.scene.dead_weight import Dropped, make_lean
from harness.scene.nodes import Problems, children, children_of_type, describe
from harness.scene.ply import check_ply
from harness.scene.variant import active_variant, parser_config

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode

DISK_SIDES = 1024
# Vertex normals within this angle (radians) of their face's normal are those of a flat mesh.
FLAT_ANGLE = 1e-4
# How far a sphere's to_world may be from a similarity, relative to its scale: float32 rounding.
SIMILARITY_TOLERANCE = 1e-5

Floats = npt.NDArray[np.float32]
Indices = npt.NDArray[np.uint32]


@dataclass(frozen=True, slots=True)
class Part:
    """One shape's share of a `Geometry`: see `harness.scene.records.Shape`.

    degenerate: numbers of the triangles of its file that were dropped, ascending.
    """

    node: int
    kind: str
    first: int
    count: int
    smooth: bool
    flip_normals: bool
    degenerate: Indices


@dataclass(frozen=True, slots=True)
class Geometry:
    """World space arrays as in `harness.scene.records.Scene`, with the part of each shape node.

    dropped: what of the meshes cannot show.
    """

    parts: list[Part]
    dropped: list[Dropped]
    vertices: Floats
    normals: Floats
    triangles: Indices
    spheres: Floats


@dataclass(frozen=True, slots=True)
class _Mesh:
    vertices: Floats
    normals: Floats | None
    triangles: Indices


def build_geometry(state: "ParserState", problems: Problems) -> Geometry:
    """Instantiate the shapes of `state` in variant scalar_rgb and gather them, in the root's order.

    What is wrong with a shape's geometry is recorded in `problems`; that shape is then left out.
    """
    parts: list[Part] = []
    dropped: list[Dropped] = []
    nothing = np.zeros(0, np.uint32)
    meshes: list[_Mesh] = []
    spheres: list[tuple[float, float, float, float]] = []
    triangle_count = vertex_count = 0
    broken = _broken_files(state, problems)
    shapes = children_of_type(state, state.nodes[0], "Shape")
    nodes = [index for index in shapes if index not in broken]
    for index, instance in _build(state, nodes, problems):
        node = state.nodes[index]
        light = bool(children_of_type(state, node, "Emitter"))
        if node.props.plugin_name() == "sphere":
            sphere, flip = _sphere(node, problems)
            if sphere is not None:
                parts.append(Part(index, "sphere", len(spheres), 1, False, flip, nothing))
                spheres.append(sphere)
            continue
        mesh = _disk(node) if node.props.plugin_name() == "disk" else _mesh(instance)
        if not _valid(mesh, node, problems, light=light):
            continue
        areas = np.linalg.norm(_face_normals(mesh.vertices, mesh.triangles), axis=1)
        lean = make_lean(mesh.vertices, mesh.normals, mesh.triangles, areas)
        for what, lost in (
            ("degenerate triangles", len(lean.degenerate)),
            ("duplicate or unused vertices", lean.duplicates),
        ):
            if lost:
                dropped.append(Dropped(what, lost, describe(state, node)))
        count, smooth = len(lean.triangles), lean.normals is not None
        parts.append(Part(index, "mesh", triangle_count, count, smooth, False, lean.degenerate))
        meshes.append(_Mesh(lean.vertices, lean.normals, lean.triangles + np.uint32(vertex_count)))
        triangle_count += count
        vertex_count += len(lean.vertices)
    no_floats, no_indices = np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)
    return Geometry(
        parts=parts,
        dropped=dropped,
        vertices=np.concatenate([no_floats, *(mesh.vertices for mesh in meshes)]),
        normals=np.concatenate(
            [
                no_floats,
                *(
                    np.zeros_like(mesh.vertices) if mesh.normals is None else mesh.normals
                    for mesh in meshes
                ),
            ]
        ),
        triangles=np.concatenate([no_indices, *(mesh.triangles for mesh in meshes)]),
        spheres=np.array(spheres, np.float32).reshape(-1, 4),
    )


def _broken_files(state: "ParserState", problems: Problems) -> set[int]:
    """Nodes of the shapes whose PLY file is broken; what is wrong is recorded."""
    broken = set()
    for index in children_of_type(state, state.nodes[0], "Shape"):
        node = state.nodes[index]
        reason = None
        if node.props.plugin_name() == "ply":
            reason = check_ply(Path(str(node.props["filename"])))
        if reason is not None:
            problems.add(node, reason)
            broken.add(index)
    return broken


def _build(state: "ParserState", nodes: Sequence[int], problems: Problems) -> list[tuple[int, Any]]:
    """Shape nodes with the shapes that Mitsuba makes of them.

    Mitsuba stops at the first shape that it cannot build. Halves are tried then, so that all such
    shapes are recorded, and left out.
    """
    try:
        return list(zip(nodes, _instances(state, nodes), strict=True))
    except RuntimeError as error:
        if "failed to instantiate shape" not in str(error):
            raise
        if len(nodes) == 1:
            problems.add(state.nodes[nodes[0]], _reason(error))
            return []
        half = len(nodes) // 2
        return _build(state, nodes[:half], problems) + _build(state, nodes[half:], problems)


def _reason(error: RuntimeError) -> str:
    """What Mitsuba says of one shape, without the place, which the message has already."""
    text = str(error).partition("failed to instantiate shape")[2].partition(": ")[2]
    return re.sub(r"\[[\w.:]+\] ", "", text).strip()


def _instances(state: "ParserState", nodes: Sequence[int]) -> list[Any]:
    """Shapes of some nodes of the scene, as Mitsuba builds them.

    In a copy of the state `diffuse` takes the place of `phong`, which is defined outside Mitsuba
    and has no scalar version, and shapes do not emit: Mitsuba would stop at a light of zero area
    without saying so. Geometry depends on neither.
    """
    import mitsuba as mi

    copy = mi.parser.ParserState(state)
    root, wanted = copy.nodes[0], set(nodes)
    for key, child in children(root):
        if copy.nodes[child].type == mi.ObjectType.Shape and child not in wanted:
            del root.props[key]
    for node in copy.nodes:
        if node.props.plugin_name() == "phong":
            stand_in = mi.Properties("diffuse")
            stand_in.set_id(node.props.id())
            node.props = stand_in
        elif node.type == mi.ObjectType.Shape:
            for key, child in children(node):
                if copy.nodes[child].type == mi.ObjectType.Emitter:
                    del node.props[key]
    with active_variant("scalar_rgb"):
        config = parser_config("scalar_rgb")
        return list(mi.parser.instantiate(config, copy).shapes())


def _mesh(instance: Any) -> _Mesh:
    """Buffers of a Mitsuba mesh in world space, `flip_normals` baked into winding and normals."""
    vertices = np.array(instance.vertex_positions_buffer(), np.float32).reshape(-1, 3)
    triangles = np.array(instance.faces_buffer(), np.uint32).reshape(-1, 3)
    normals = None
    if instance.has_vertex_normals():
        normals = np.array(instance.vertex_normals_buffer(), np.float32).reshape(-1, 3)
    if instance.has_flipped_normals():
        triangles = np.ascontiguousarray(triangles[:, [0, 2, 1]])
        normals = None if normals is None else -normals
    in_range = not triangles.size or int(triangles.max()) < len(vertices)
    if normals is not None and in_range and _flat(vertices, normals, triangles):
        normals = None
    return _Mesh(vertices, normals, triangles)


def _face_normals(vertices: Floats, triangles: Indices) -> npt.NDArray[np.float64]:
    """Normals of triangles, as long as twice their area. float64 [T, 3]."""
    corners = vertices[triangles].astype(np.float64)
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _flat(vertices: Floats, normals: Floats, triangles: Indices) -> bool:
    """Whether every vertex normal is that of its faces, so that interpolating changes nothing."""
    faces = _face_normals(vertices, triangles)
    lengths = np.linalg.norm(faces, axis=1)
    solid = lengths > 0.0
    faces = faces[solid] / lengths[solid, None]
    corners = normals[triangles[solid]].astype(np.float64)
    sines = np.linalg.norm(np.cross(corners, faces[:, None]), axis=2)
    cosines = np.einsum("tcx,tx->tc", corners, faces)
    return bool(np.all((sines < FLAT_ANGLE) & (cosines > 0.0)))


def _valid(mesh: _Mesh, node: "SceneNode", problems: Problems, *, light: bool) -> bool:
    """Record what is wrong with a mesh; False if it cannot be used."""
    if not len(mesh.triangles):
        problems.add(node, "the mesh has no triangles")
        return False
    largest = int(mesh.triangles.max())
    if largest >= len(mesh.vertices):
        problems.add(
            node, f"a triangle refers to vertex {largest} of a mesh of {len(mesh.vertices)}"
        )
        return False
    used = np.unique(mesh.triangles)
    bad = used[~np.isfinite(mesh.vertices[used]).all(axis=1)]
    if bad.size:
        problems.add(node, f"vertex {bad[0]} is not finite: {mesh.vertices[bad[0]].tolist()}")
        return False
    faces = _face_normals(mesh.vertices, mesh.triangles)
    doubled_area = np.linalg.norm(faces, axis=1)
    if light and not doubled_area.sum() > 0.0:
        problems.add(node, "a light of zero area")
        return False
    if mesh.normals is None:
        return True
    solid = np.unique(mesh.triangles[doubled_area > 0.0])
    lengths = np.linalg.norm(mesh.normals[solid].astype(np.float64), axis=1)
    bad = solid[~(np.isfinite(lengths) & (lengths > 0.0))]
    if bad.size:
        problems.add(node, f"the normal of vertex {bad[0]} is zero or not finite")
        return False
    turned = np.einsum("tcx,tx->tc", mesh.normals[mesh.triangles], faces).max(axis=1) < 0.0
    if doubled_area[turned].sum() > 0.5 * doubled_area.sum():
        problems.add(
            node,
            "the winding of its triangles contradicts its vertex normals "
            "(a mirroring to_world, or a broken file)",
        )
        return False
    return True


def _disk(node: "SceneNode") -> _Mesh:
    """Mitsuba's disk as a regular polygon of the same area, without vertex normals."""
    to_world = to_world_matrix(node.props)
    step = 2.0 * math.pi / DISK_SIDES
    radius = math.sqrt(step / math.sin(step))
    angles = step * np.arange(DISK_SIDES)
    points = np.zeros((DISK_SIDES + 1, 3))
    points[1:, 0], points[1:, 1] = radius * np.cos(angles), radius * np.sin(angles)
    rim = np.arange(DISK_SIDES)
    triangles = np.stack([np.zeros_like(rim), rim + 1, (rim + 1) % DISK_SIDES + 1], axis=1).astype(
        np.uint32
    )
    # Normals transform by the inverse transpose, so a mirroring to_world does not turn them.
    if (np.linalg.det(to_world[:3, :3]) < 0.0) != bool(node.props.get("flip_normals", False)):
        triangles = np.ascontiguousarray(triangles[:, [0, 2, 1]])
    vertices = points @ to_world[:3, :3].T + to_world[:3, 3]
    return _Mesh(vertices.astype(np.float32), None, triangles)


def _sphere(
    node: "SceneNode", problems: Problems
) -> tuple[tuple[float, float, float, float] | None, bool]:
    """Centre and radius of a sphere node in world space, and whether its normal points inwards."""
    to_world = to_world_matrix(node.props)
    linear = to_world[:3, :3]
    centre = np.array(node.props.get("center", [0.0, 0.0, 0.0]), np.float64).reshape(3)
    radius = float(node.props.get("radius", 1.0))
    squared_scale = float(np.trace(linear.T @ linear)) / 3.0
    residual = linear.T @ linear - squared_scale * np.eye(3)
    if np.abs(residual).max() > 2.0 * SIMILARITY_TOLERANCE * squared_scale:
        problems.add(node, "a sphere must be scaled uniformly and not sheared")
        return None, False
    centre = linear @ centre + to_world[:3, 3]
    world_radius = radius * math.sqrt(squared_scale)
    if not np.isfinite(centre).all():
        problems.add(node, f"the centre is not finite: {centre.tolist()}")
        return None, False
    if not (0.0 < world_radius < math.inf):
        problems.add(node, f"the radius must be positive and finite, not {world_radius:g}")
        return None, False
    # Mitsuba turns the normal of a sphere that is mirrored.
    flip = bool(node.props.get("flip_normals", False)) != (np.linalg.det(linear) < 0.0)
    return (float(centre[0]), float(centre[1]), float(centre[2]), world_radius), bool(flip)
