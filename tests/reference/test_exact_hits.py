"""The exact predicate: does a ray in single precision meet a closed triangle?"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from reference.exact_hits import Pair, determinant_sign, difference, meets

Singles = NDArray[np.float32]
Vector = list[Fraction]


def exact(values: Singles) -> Vector:
    return [Fraction(float(value)) for value in values]


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def meets_in_fractions(corners: Singles, origin: Singles, direction: Singles) -> bool:
    """The definition, in rational numbers."""
    start, towards = exact(origin), exact(direction)
    a, b, c = ([x - y for x, y in zip(exact(p), start, strict=True)] for p in corners)
    volumes = [dot(towards, cross(p, q)) for p, q in ((a, b), (b, c), (c, a))]
    if min(volumes) < 0 < max(volumes) or not any(volumes):
        return False
    return dot(a, cross(b, c)) / sum(volumes) > 0


def aimed(count: int, seed: int) -> tuple[Singles, Singles, Singles]:
    """Rays at corners, edges and interiors of triangles, from near and far."""
    random = np.random.default_rng(seed)
    corners = random.normal(size=(count, 3, 3)).astype(np.float32)
    origins = random.normal(size=(count, 3)) * 10.0 ** random.uniform(-3, 6, (count, 1))
    origins = origins.astype(np.float32)
    weights = random.dirichlet(np.ones(3), count)
    weights[::3] = [1, 0, 0]
    weights[1::3, 2] = 0
    targets = np.einsum("nk,nkc->nc", weights, corners.astype(np.float64))
    return corners, origins, (targets - origins).astype(np.float32)


def lattice(count: int, seed: int) -> tuple[Singles, Singles, Singles]:
    """Small whole numbers: rays through corners and along edges, in planes, at no distance, and
    triangles without an area."""
    random = np.random.default_rng(seed)
    shapes = ((count, 3, 3), (count, 3), (count, 3))
    corners, origins, directions = (
        random.integers(-2, 3, shape).astype(np.float32) for shape in shapes
    )
    return corners, origins, directions


@pytest.mark.parametrize("rays", [aimed, lattice])
def test_what_is_decided_is_what_rational_numbers_say(rays: object) -> None:
    corners, origins, directions = rays(2000, 1)  # type: ignore[operator]
    found = meets(corners, origins, directions)
    truth = [meets_in_fractions(*one) for one in zip(corners, origins, directions, strict=True)]
    assert 0.02 < np.mean(truth) < 0.98
    wrong = np.flatnonzero(found != truth)
    assert not len(wrong), (
        f"{len(wrong)} rays, the first: {corners[wrong[0]].tolist()}, "
        f"{origins[wrong[0]].tolist()}, {directions[wrong[0]].tolist()}"
    )


def test_single_precision_does_not_decide_it() -> None:
    """Negative control: the rays are such that rounding matters."""
    corners, origins, directions = aimed(2000, 1)
    a, b, c = (corners[:, i] - origins for i in range(3))
    volumes = [(directions * np.cross(p, q)).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))]
    rounded = (np.min(volumes, axis=0) >= 0) | (np.max(volumes, axis=0) <= 0)
    assert (rounded != meets(corners, origins, directions)).mean() > 0.02


def test_signs_are_right_where_doubles_and_pairs_of_them_cannot_tell() -> None:
    """Determinants of 0, and of the least number that the products can differ by."""
    # 2^60 + 1 needs two doubles, and its square four.
    wide = difference(np.full(3, 2.0**60), np.full(3, -1.0))
    none = np.zeros(3)
    nearly = wide.low + np.array([-1.0, 0.0, 1.0])
    one = Pair(np.stack([wide.high, wide.high, none]), np.stack([wide.low, wide.low, none]))
    other = Pair(np.stack([wide.high, wide.high, none]), np.stack([wide.low, nearly, none]))
    up = Pair(np.stack([none, none, np.ones(3)]), np.zeros((3, 3)))
    assert determinant_sign(one, other, up).tolist() == [-1, 0, 1]


def test_a_ray_behind_its_origin_and_a_triangle_edge_on_are_not_met() -> None:
    corners = np.array([[[0, 0, 1], [1, 0, 1], [0, 1, 1]]] * 3, np.float32)
    corners[2] = [[0, 0, 1], [0, 0, 2], [1, 0, 1]]
    origins = np.array([[0.25, 0.25, 0], [0.25, 0.25, 2], [0.25, 0, 0]], np.float32)
    directions = np.tile(np.array([[0, 0, 1]], np.float32), (3, 1))
    assert meets(corners, origins, directions).tolist() == [True, False, False]
