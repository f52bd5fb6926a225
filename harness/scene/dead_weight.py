"""What of a scene cannot show in any picture, which import drops and names.

Nothing that is dropped changes a bit of a picture: the scene renders as one that never had it. A
light that gives none would otherwise be chosen as often as the others.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from harness.scene.nodes import Problems, children_of_type, colour, describe, number

if TYPE_CHECKING:
    import mitsuba as mi

    from harness.scene.records import Material

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode

Floats = npt.NDArray[np.float32]
Indices = npt.NDArray[np.uint32]

COLOURS = {
    "diffuse_reflectance": "diffuse",
    "specular_reflectance": "specular",
    "ambient_reflectance": "ambient",
}
"""Parameters of `phong` that weigh a lobe, and the lobe."""
SHARES = {"reflection": "mirror", "transmission": "refraction"}


@dataclass(frozen=True, slots=True)
class Dropped:
    """Something that import left out.

    what: in the plural where `count` is not 1, "degenerate triangles". of: the node, with its
    place.
    """

    what: str
    count: int
    of: str

    def __str__(self) -> str:
        return f"{self.count:,} {self.what} of {self.of}"


@dataclass(frozen=True, slots=True)
class LeanMesh:
    """A mesh without dead weight, and the numbers of the triangles that it had besides."""

    vertices: Floats
    normals: Floats | None
    triangles: Indices
    degenerate: Indices
    """uint32, ascending, in the order of the file"""
    duplicates: int
    """vertices that were equal to others, or that no triangle refers to"""


def make_lean(
    vertices: Floats, normals: Floats | None, triangles: Indices, areas: npt.NDArray[np.float64]
) -> LeanMesh:
    """Drop triangles without area, and all vertices but the first of those that are equal.

    Vertices are equal where positions and normals are, bit for bit: two that differ in their
    normals are both sides of a crease.

    Parameters
    ----------
    vertices, normals
        float32 [V, 3]; normals None where the mesh is flat.
    triangles
        uint32 [T, 3].
    areas
        float64 [T], areas of the triangles, in any unit.
    """
    degenerate = np.flatnonzero(areas == 0.0).astype(np.uint32)
    if degenerate.size:
        triangles = np.ascontiguousarray(triangles[areas > 0.0])
    rows = vertices if normals is None else np.concatenate([vertices, normals], axis=1)
    first = _first_equal(np.ascontiguousarray(rows).view(np.uint32))
    kept = np.zeros(len(vertices), bool)
    kept[first[triangles]] = True
    duplicates = len(vertices) - int(kept.sum())
    if duplicates:
        number_of = (np.cumsum(kept) - 1).astype(np.uint32)
        triangles = np.ascontiguousarray(number_of[first[triangles]])
        vertices = np.ascontiguousarray(vertices[kept])
        normals = None if normals is None else np.ascontiguousarray(normals[kept])
    return LeanMesh(vertices, normals, triangles, degenerate, duplicates)


def _first_equal(rows: Indices) -> npt.NDArray[np.intp]:
    """Index of the first row that equals each row. intp [N]."""
    if not len(rows):
        return np.zeros(0, np.intp)
    # A row in one word, so that sorting is quick; equal words are looked at again.
    words = np.zeros(len(rows), np.uint64)
    for column in rows.T:
        words = (words ^ column) * np.uint64(0x9E3779B97F4A7C15)
        words ^= words >> np.uint64(29)
    _, first, inverse = np.unique(words, return_index=True, return_inverse=True)
    found = first[inverse]
    if not np.array_equal(rows[found], rows):
        _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        found = first[inverse.ravel()]
    return np.asarray(found, np.intp)


def unused_materials(state: "ParserState") -> list[Dropped]:
    """Materials that the scene holds and no shape refers to."""
    root = state.nodes[0]
    shapes = children_of_type(state, root, "Shape")
    used = {
        bsdf for shape in shapes for bsdf in children_of_type(state, state.nodes[shape], "BSDF")
    }
    unused = [bsdf for bsdf in children_of_type(state, root, "BSDF") if bsdf not in used]
    return [Dropped("unused material", 1, describe(state, state.nodes[bsdf])) for bsdf in unused]


def weightless_lobes(
    state: "ParserState", node: "SceneNode", material: "Material"
) -> list[Dropped]:
    """Lobes of a BSDF that a scene writes with the weight 0, and a second side that has none.

    material: what the BSDF is imported as.
    """
    if node.props.plugin_name() == "twosided":
        inner = state.nodes[children_of_type(state, node, "BSDF")[0]]
        lost = [] if material.twosided else [Dropped("black second side", 1, describe(state, node))]
        return [*lost, *weightless_lobes(state, inner, material)]
    if node.props.plugin_name() != "phong":
        return []
    problems = Problems(state)
    found = [
        lobe
        for name, lobe in COLOURS.items()
        if name in node.props and max(colour(problems, node, name, (1.0, 1.0, 1.0))) == 0.0
    ]
    found += [
        lobe
        for name, lobe in SHARES.items()
        if name in node.props and number(problems, node, name, 1.0) == 0.0
    ]
    return [Dropped(f"{lobe} lobe without weight", 1, describe(state, node)) for lobe in found]
