"""The edges and vertices of a mesh that triangles surround, and those triangles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vertices = NDArray[np.float32]
Triangles = NDArray[np.uint32]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Rings:
    """Edges or vertices, E of them, and the triangles about each.

    ends: int64 [E, 2], vertices of the edge, or the same vertex twice. first: int64 [E + 1], where
    the triangles of each begin in `triangle`, int64 [P]. rim: bool [P, 3], which edges of these lie
    on the rim of the ring, the one after each corner.
    """

    ends: Integers
    first: Integers
    triangle: Integers
    rim: Booleans

    def __len__(self) -> int:
        return len(self.ends)

    def pairs_of(self, ring: Integers) -> tuple[Integers, Integers]:
        """Places in `triangle` of the triangles about each of `ring`, one after another, and where
        each one's begin: int64 [Q] and [len(ring) + 1].
        """
        counts = self.first[ring + 1] - self.first[ring]
        begin = np.concatenate([[0], np.cumsum(counts)])
        return np.arange(begin[-1]) + np.repeat(self.first[ring] - begin[:-1], counts), begin


def weld(vertices: Vertices, triangles: Triangles) -> Integers:
    """Triangles by the places of their corners: corners in one place have one number."""
    _, number = np.unique(vertices + np.float32(0.0), axis=0, return_inverse=True)
    return number.reshape(-1)[triangles.astype(np.int64)]


def edge_rings(vertices: Vertices, triangles: Triangles) -> Rings:
    """Edges with two triangles, which pass it in opposite directions."""
    welded = weld(vertices, triangles)
    good = _with_area(vertices, triangles)
    triangle = np.tile(np.arange(len(triangles)), 3)
    side = np.repeat(np.arange(3), len(triangles))
    a, b = welded[triangle, side], welded[triangle, (side + 1) % 3]
    key = np.minimum(a, b) * (welded.max(initial=0) + 1) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    starts, counts = np.unique(key[order], return_index=True, return_counts=True)[1:]
    pair = order[starts[counts == 2][:, None] + np.arange(2)]
    whole = (a[pair[:, 0]] == b[pair[:, 1]]) & (a[pair[:, 0]] != b[pair[:, 0]])
    whole &= good[triangle[pair]].all(axis=1)
    pair = pair[whole]
    corner = triangles.astype(np.int64)
    one = pair[:, 0]
    ends = np.stack(
        [corner[triangle[one], side[one]], corner[triangle[one], (side[one] + 1) % 3]], axis=1
    )
    rim = np.ones((2 * len(pair), 3), bool)
    rim[np.arange(2 * len(pair)), side[pair].ravel()] = False
    return Rings(ends, 2 * np.arange(len(pair) + 1), triangle[pair].ravel(), rim)


def vertex_rings(vertices: Vertices, triangles: Triangles) -> Rings:
    """Vertices whose triangles close around them, once: each edge out of them has two."""
    welded = weld(vertices, triangles)
    good = _with_area(vertices, triangles)
    count = int(welded.max(initial=-1)) + 1
    centre, triangle = welded.ravel(), np.repeat(np.arange(len(triangles)), 3)
    side = np.tile(np.arange(3), len(triangles))
    after, before = welded[triangle, (side + 1) % 3], welded[triangle, (side + 2) % 3]
    order = np.argsort(centre, kind="stable")
    valence = np.bincount(centre, minlength=count)
    # Once around: as many different vertices after the centre as before, and the same ones.
    outwards = _distinct(centre, after, count)
    inwards = _distinct(centre, before, count)
    both = _distinct(np.tile(centre, 2), np.concatenate([after, before]), count)
    whole = (valence >= 3) & (outwards == valence) & (inwards == valence) & (both == valence)
    whole &= np.bincount(centre, weights=~good[triangle], minlength=count) == 0
    kept = order[whole[centre[order]]]
    first = np.concatenate([[0], np.cumsum(valence[whole])])
    here = triangles.astype(np.int64).ravel()[kept[first[:-1]]]
    rim = np.zeros((len(kept), 3), bool)
    rim[np.arange(len(kept)), (side[kept] + 1) % 3] = True
    return Rings(np.stack([here, here], axis=1), first, triangle[kept], rim)


def _distinct(centre: Integers, other: Integers, count: int) -> Integers:
    """How many different neighbours each vertex has among `other`."""
    pairs = np.unique(np.stack([centre, other], axis=1), axis=0)
    return np.bincount(pairs[:, 0], minlength=count)


def _with_area(vertices: Vertices, triangles: Triangles) -> Booleans:
    corners = vertices[triangles].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal.any(axis=1)
