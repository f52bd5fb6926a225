"""Solids that models are made of: arrays of triangle corners [T, 3, 3], wound outwards."""

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

Corners = npt.NDArray[np.float64]
Vector = Sequence[float]

SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def box(size: Vector, bevel: float = 0.0) -> Corners:
    """A box around the origin, its edges and corners cut off by `bevel`."""
    half = np.asarray(size, float) / 2.0
    inner = half - bevel
    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1.0, 1.0):
            face = np.full((4, 3), sign * half[axis])
            face[:, [u, v]] = SQUARE * inner[[u, v]]
            quads.append(face)
        if bevel > 0.0:
            for along_u, along_v in product((-1.0, 1.0), repeat=2):
                edge = np.empty((4, 3))
                edge[:, axis] = SQUARE[:, 0] * inner[axis]
                edge[:, u] = along_u * (inner[u] + bevel * (SQUARE[:, 1] < 0.0))
                edge[:, v] = along_v * (inner[v] + bevel * (SQUARE[:, 1] > 0.0))
                quads.append(edge)
    corners = np.array(quads)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3, 3)
    if bevel > 0.0:
        octants = np.array(list(product((-1.0, 1.0), repeat=3)))
        corners = np.concatenate([corners, octants[:, None] * (inner + bevel * np.eye(3))])
    return outwards(corners)


def outwards(corners: Corners) -> Corners:
    """Triangles of a body that is star-shaped about the origin, wound outwards."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("tx,tx->t", normals, corners.mean(axis=1)) < 0.0
    corners[inwards] = corners[inwards, ::-1]
    return corners


def lathe(profile: Sequence[Vector], segments: int, *, closed: bool = True) -> Corners:
    """The body of revolution about z of a profile of points (radius, height).

    The profile runs counter-clockwise around the inside of the body, height being up and radius to
    the right; where it is not `closed` it starts and ends on the axis.
    """
    points = np.asarray(profile, float)
    if closed:
        points = np.concatenate([points, points[:1]])
    angles = 2.0 * math.pi * np.arange(segments) / segments
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    surface = np.empty((len(points), segments, 3))
    surface[..., :2] = points[:, None, :1] * ring[None]
    surface[..., 2] = points[:, None, 1]
    return skin(np.concatenate([surface, surface[:, :1]], axis=1))


def skin(surface: Corners) -> Corners:
    """Triangles between neighbours of a net of points [rows, columns, 3], none without area.

    Seen from outside, columns run to the right where rows run up.
    """
    a, b = surface[:-1, :-1], surface[:-1, 1:]
    c, d = surface[1:, 1:], surface[1:, :-1]
    corners = np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return corners[np.linalg.norm(normals, axis=1) > 0.0]


def tube(path: Sequence[Vector], radii: Sequence[float], sides: int) -> Corners:
    """A round bar along a path of points, closed at its ends."""
    points = np.asarray(path, float)
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along).max(axis=0))])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    third = np.cross(along, across)
    angles = 2.0 * math.pi * np.arange(sides + 1) / sides
    angles[-1] = 0.0
    circle = np.cos(angles)[:, None] * across[:, None] + np.sin(angles)[:, None] * third[:, None]
    surface = points[:, None] + np.asarray(radii, float)[:, None, None] * circle
    ends = [np.repeat(points[end][None, None], sides + 1, axis=1) for end in (0, -1)]
    return skin(np.concatenate([ends[0], surface, ends[1]]))


def move(
    corners: Corners, offset: Vector = (0, 0, 0), *, axis: Vector = (0, 0, 1), degrees: float = 0
) -> Corners:
    """Turn about an axis through the origin, then translate."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
    angle = math.radians(degrees)
    turn = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return corners @ turn.T + np.asarray(offset, float)


def mirror(corners: Corners, axis: int) -> Corners:
    """The image in the plane through the origin across an axis."""
    signs = np.ones(3)
    signs[axis] = -1.0
    return (corners * signs)[:, ::-1]


def crease_normals(corners: Corners, degrees: float) -> Corners:
    """Normals of the corners: of the faces at the same point that turn by less than an angle.

    Each is the mean weighted by area over those faces of one solid that meet the corner's own at
    less than `degrees`. [T, 3, 3].
    """
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    directions = faces / np.linalg.norm(faces, axis=1, keepdims=True)
    points = np.round(corners.reshape(-1, 3), 9) + 0.0
    _, where = np.unique(points, axis=0, return_inverse=True)
    order = np.argsort(where.reshape(-1), kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(where.reshape(-1)))[:-1])
    normals = np.empty_like(points)
    limit = math.cos(math.radians(degrees))
    for group in groups:
        owners = group // 3
        near = directions[owners] @ directions[owners].T > limit
        normals[group] = near @ faces[owners]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals.reshape(-1, 3, 3)
