"""Rays for their own sake: closest and any hit, against double precision and each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from core_meshes import directions, mesh_scene, star
from numpy.typing import NDArray

import haste_cuda
from harness.scene import load_scene
from harness.tracers.haste import to_core

NONE = 0xFFFFFFFF
UNIT = 2.0**-24
SKULL = Path(__file__).parents[2] / "scenes" / "skull"
INTERSECTORS = ("haste", "embree")
Floats = NDArray[np.float64]
Trace = Callable[..., dict[str, Any]]


@dataclass(frozen=True)
class Truth:
    """Hits in double precision of rays with all triangles."""

    t: Floats
    primitive: NDArray[np.int64]
    clear: NDArray[np.bool_]
    """whether triangles grown and shrunk by the rounding of a ray give the same primitive"""
    bound: Floats
    """how far rounding may move t"""


def brute_force(
    corners: Floats, origins: Floats, towards: Floats, t_min: Floats, t_max: Floats
) -> Truth:
    """Möller and Trumbore's test of every ray with every triangle, corners float64 [T, 3, 3].

    A vertex in the ray's coordinates carries about eight roundings of its distance R from the
    origin: it moves sideways by delta = 8 u R, which is delta over the triangle's least altitude in
    barycentrics, and by delta (1 + tan) along a ray that meets the plane at that slope.
    """
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(e1, e2)
    area = np.linalg.norm(normal, axis=1)
    edges = np.stack([e1, e2, e2 - e1], axis=1)
    altitude = area / np.linalg.norm(edges, axis=2).max(axis=1)
    count = len(origins)
    t, bound = np.full(count, np.inf), np.zeros(count)
    primitive, clear = np.full(count, -1), np.zeros(count, bool)
    for i, (o, d) in enumerate(zip(origins, towards, strict=True)):
        delta = 8 * UNIT * np.abs(corners - o).max(axis=(1, 2))
        with np.errstate(all="ignore"):
            p, s = np.cross(d, e2), o - a
            determinant = (e1 * p).sum(-1)
            q = np.cross(s, e1)
            u, w = (s * p).sum(-1) / determinant, q @ d / determinant
            distance = (e2 * q).sum(-1) / determinant
            slack = delta / altitude
            cosine = np.abs(normal @ d) / (area * np.linalg.norm(d))
            error = delta * (1 + 1 / cosine) / np.linalg.norm(d)
        least = np.minimum(np.minimum(u, w), 1 - u - w)
        found = []
        for sign in (0, 1, -1):
            inside = (least >= sign * slack) & (determinant != 0)
            inside &= (distance > t_min[i] + sign * error) & (distance <= t_max[i] - sign * error)
            found.append(int(np.argmin(np.where(inside, distance, np.inf))) if inside.any() else -1)
        best = found[0]
        primitive[i] = best
        clear[i] = found[0] == found[1] == found[2]
        if best >= 0:
            t[i], bound[i] = distance[best], error[best]
    return Truth(t, primitive, clear, bound)


@dataclass(frozen=True)
class Case:
    scene: haste_cuda.Scene
    corners: Floats
    origins: NDArray[np.float32]
    towards: NDArray[np.float32]
    t_min: NDArray[np.float32]
    t_max: NDArray[np.float32]

    def trace(self, **how: object) -> dict[str, object]:
        arrays = (self.origins, self.towards, self.t_min, self.t_max)
        return haste_cuda.trace_cpu(self.scene, *arrays, **how)

    def truth(self) -> Truth:
        arrays = (self.origins, self.towards, self.t_min, self.t_max)
        return brute_force(self.corners, *(array.astype(np.float64) for array in arrays))


def rays_across(corners: Floats, count: int, seed: int) -> tuple[NDArray[np.float32], ...]:
    """Rays from around a mesh to points near it: lengths and intervals of every kind."""
    random = np.random.default_rng(seed)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    centre, reach = (low + high) / 2, np.linalg.norm(high - low)
    origins = centre + reach * directions(count, seed + 1)
    towards = random.uniform(low, high, (count, 3)) - origins
    # Directions of no particular length: t is in units of them.
    towards *= random.uniform(0.2, 3.0, (count, 1))
    length = np.linalg.norm(towards, axis=1)
    t_min = np.where(
        random.random(count) < 0.5, 0.0, random.uniform(0, 1.5, count) * reach / length
    )
    t_max = np.where(random.random(count) < 0.5, np.inf, t_min + random.uniform(0, 2, count))
    return tuple(array.astype(np.float32) for array in (origins, towards, t_min, t_max))


@pytest.fixture(scope="module")
def star_case() -> Case:
    vertices, triangles = star(12)
    corners = vertices[triangles].astype(np.float64)
    return Case(mesh_scene(vertices, triangles), corners, *rays_across(corners, 4000, 20))


@pytest.fixture(scope="module")
def skull_case() -> Case:
    scene = load_scene(SKULL)
    corners = scene.vertices[scene.triangles].astype(np.float64)
    first = next(shape for shape in scene.shapes if shape.name == "skull")
    rays = rays_across(corners[first.first : first.first + first.count], 300, 30)
    return Case(to_core(scene, 1), corners, *rays)


@pytest.fixture(scope="module")
def star_truth(star_case: Case) -> Truth:
    return star_case.truth()


@pytest.fixture(scope="module")
def skull_truth(skull_case: Case) -> Truth:
    return skull_case.truth()


def error_of_closest(case: Case, truth: Truth, answer: dict[str, object]) -> str:
    """In what an answer differs from double precision beyond rounding; empty if in nothing."""
    primitive = np.asarray(answer["primitive"]).astype(np.int64)
    primitive[primitive == NONE] = -1
    clear = truth.clear
    if clear.mean() <= 0.99:
        return f"only {clear.mean():.2%} of the rays can be judged"
    wrong = np.flatnonzero(clear & (primitive != truth.primitive))
    if wrong.size:
        return (
            f"{wrong.size} rays, the first {wrong[0]}: origin {case.origins[wrong[0]]}, direction "
            f"{case.towards[wrong[0]]}: {primitive[wrong[0]]}, not {truth.primitive[wrong[0]]}"
        )
    hit = clear & (primitive >= 0)
    t = np.asarray(answer["t"], np.float64)
    if (np.isfinite(t) != (primitive >= 0)).any():
        return f"rays {np.flatnonzero(np.isfinite(t) != (primitive >= 0))}: t without primitive"
    error = np.abs(t[hit] - truth.t[hit]) / truth.bound[hit]
    return "" if error.max() <= 1.0 else f"t is off by {error.max():.3g} of what rounding allows"


@pytest.mark.parametrize("intersector", INTERSECTORS)
def test_closest_hits_of_a_star_are_those_of_double_precision(
    star_case: Case, star_truth: Truth, intersector: str
) -> None:
    error = error_of_closest(star_case, star_truth, star_case.trace(intersector=intersector))
    assert not error, f"{intersector}: {error}"


@pytest.mark.parametrize("intersector", INTERSECTORS)
def test_closest_hits_of_the_skull_are_those_of_double_precision(
    skull_case: Case, skull_truth: Truth, intersector: str
) -> None:
    error = error_of_closest(skull_case, skull_truth, skull_case.trace(intersector=intersector))
    assert not error, f"{intersector}: {error}"


def test_a_missing_triangle_is_seen_by_the_comparison(star_case: Case, star_truth: Truth) -> None:
    """Negative control: the same rays through a star without the triangle that most of them hit."""
    vertices, triangles = star(12)
    often = np.bincount(star_truth.primitive[star_truth.primitive >= 0]).argmax()
    broken = replace(star_case, scene=mesh_scene(vertices, np.delete(triangles, often, axis=0)))
    error = error_of_closest(broken, star_truth, broken.trace())
    assert "rays, the first" in error, error


@pytest.mark.parametrize("intersector", INTERSECTORS)
def test_any_hit_is_found_where_a_closest_one_is(star_case: Case, intersector: str) -> None:
    closest = star_case.trace(intersector=intersector)
    found = star_case.trace(intersector=intersector, any_hit=True)
    hit = np.isfinite(closest["t"])
    assert 0.1 < hit.mean() < 0.9, hit.mean()
    assert (np.isfinite(found["t"]) == hit).all()
    assert (found["t"][hit] == 0.0).all() and (found["primitive"] == NONE).all()


def test_the_interval_is_open_below_and_closed_above(star_case: Case) -> None:
    count = len(star_case.origins)
    zero, far = np.zeros(count, np.float32), np.full(count, np.inf, np.float32)
    rays = (star_case.origins, star_case.towards)
    first = haste_cuda.trace_cpu(star_case.scene, *rays, zero, far)
    hit = np.isfinite(first["t"])
    rays, t = (rays[0][hit], rays[1][hit]), first["t"][hit]
    zero, far = zero[hit], far[hit]
    until = haste_cuda.trace_cpu(star_case.scene, *rays, zero, t)
    before = haste_cuda.trace_cpu(star_case.scene, *rays, zero, np.nextafter(t, np.float32(0.0)))
    after = haste_cuda.trace_cpu(star_case.scene, *rays, t, far)
    assert (until["t"] == t).all() and (until["primitive"] == first["primitive"][hit]).all()
    assert (before["primitive"] == NONE).all()
    assert (after["t"] > t).all()
    # A closed mesh, entered from outside, is left again, through another triangle.
    assert np.isfinite(after["t"]).all()
    assert (after["primitive"] != first["primitive"][hit]).all()


@pytest.mark.parametrize("intersector", INTERSECTORS)
def test_beyond_its_near_side_a_sphere_is_hit_on_the_far_one(intersector: str) -> None:
    no_mesh = (np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32))
    scene = mesh_scene(*no_mesh, [(0, 0, 0, 1), (0, 0, 10, 2)])
    origins = np.tile(np.array([[0, 0, -3]], np.float32), (5, 1))
    towards = np.tile(np.array([[0, 0, 2]], np.float32), (5, 1))
    t_min = np.array([0, 1.5, 2.5, 6.0, 8.0], np.float32)
    far = np.full(5, np.inf, np.float32)
    answer = haste_cuda.trace_cpu(scene, origins, towards, t_min, far, intersector=intersector)
    assert answer["t"].tolist() == [1.0, 2.0, 5.5, 7.5, np.inf]
    assert answer["primitive"].tolist() == [0, 0, 1, 1, NONE]


def test_mixed_scenes_number_spheres_after_triangles() -> None:
    vertices, triangles = star(12)
    scene = mesh_scene(vertices, triangles, [(0, 0, 5, 0.5)])
    origins = np.array([[0, 0, 9], [0, 0, -9]], np.float32)
    towards = -origins
    ends = (np.zeros(2, np.float32), np.full(2, np.inf, np.float32))
    for intersector in INTERSECTORS:
        hit = haste_cuda.trace_cpu(scene, origins, towards, *ends, intersector=intersector)
        assert hit["primitive"][0] == len(triangles), hit
        assert hit["primitive"][1] < len(triangles), hit


def test_hits_depend_on_neither_threads_nor_the_order_of_the_rays(star_case: Case) -> None:
    one, two = star_case.trace(threads=1), star_case.trace(threads=2)
    order = np.random.default_rng(5).permutation(len(star_case.origins))
    arrays = (star_case.origins, star_case.towards, star_case.t_min, star_case.t_max)
    shuffled = haste_cuda.trace_cpu(star_case.scene, *(array[order] for array in arrays))
    for name in ("t", "primitive"):
        assert np.array_equal(one[name], two[name]), name
        assert np.array_equal(one[name][order], shuffled[name]), name


@pytest.mark.parametrize("trace", [haste_cuda.trace_cpu, haste_cuda.trace_embree])
def test_rays_that_are_held_have_the_hits_of_their_arrays(star_case: Case, trace: Trace) -> None:
    arrays = (star_case.origins, star_case.towards, star_case.t_min, star_case.t_max)
    expected = trace(star_case.scene, *arrays)
    # They are copied: what becomes of the arrays does not matter.
    copies = [array.copy() for array in arrays]
    held = haste_cuda.Rays(*copies)
    for array in copies:
        array[:] = np.nan
    assert len(held) == len(star_case.origins)
    for _ in range(2):
        found = trace(star_case.scene, held)
        for name in ("t", "primitive"):
            assert np.array_equal(found[name], expected[name]), name


@pytest.mark.parametrize("trace", [haste_cuda.trace_cpu, haste_cuda.trace_embree])
def test_without_hits_there_are_times_alone(star_case: Case, trace: Trace) -> None:
    arrays = (star_case.origins, star_case.towards, star_case.t_min, star_case.t_max)
    answer = trace(star_case.scene, *arrays, hits=False, repeats=2)
    assert not {"t", "primitive"} & answer.keys() and len(answer["seconds"]) == 2, answer


def test_what_is_visited_is_a_mean_over_the_rays_also_without_hits(star_case: Case) -> None:
    counted = star_case.trace(count=True)
    alone = star_case.trace(count=True, hits=False)
    for name in ("nodes", "triangles"):
        assert alone[name] == counted[name] > 0.0, (name, alone[name], counted[name])


def test_no_ray_is_no_hit(star_case: Case) -> None:
    none = np.zeros((0, 3), np.float32)
    ends = np.zeros(0, np.float32)
    for how in ({}, {"any_hit": True}, {"intersector": "embree"}):
        answer = haste_cuda.trace_cpu(star_case.scene, none, none, ends, ends, **how)
        assert answer["t"].shape == (0,) and answer["primitive"].shape == (0,)


ORIGIN, TOWARDS = np.zeros((2, 3), np.float32), np.ones((2, 3), np.float32)
START, END = np.zeros(2, np.float32), np.ones(2, np.float32)


def changed(array: NDArray[np.float32], value: float) -> NDArray[np.float32]:
    """A copy whose second entry is `value`."""
    copy = array.copy()
    copy[1] = value
    return copy


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        (
            (ORIGIN, TOWARDS[:1], START, END),
            "origins, directions, t_min and t_max must have one entry a ray, not 2, 1, 2 and 2",
        ),
        ((changed(ORIGIN, np.nan), TOWARDS, START, END), "ray 1: its origin is not finite"),
        ((ORIGIN, changed(TOWARDS, np.inf), START, END), "ray 1: its direction is not finite"),
        ((ORIGIN, changed(TOWARDS, 0), START, END), "ray 1: its direction is zero"),
        (
            (ORIGIN, TOWARDS, changed(START, -1), END),
            "ray 1: t_min must be finite and not negative",
        ),
        ((ORIGIN, TOWARDS, changed(START, 2), END), "ray 1: t_max must not be below t_min"),
        ((ORIGIN, TOWARDS, START, changed(END, np.nan)), "ray 1: t_max must not be below t_min"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_rays_that_make_no_sense_are_refused_by_number(
    star_case: Case, arrays: tuple[NDArray[np.float32], ...], message: str
) -> None:
    with pytest.raises(ValueError) as refusal:  # noqa: PT011 - the whole message is compared
        haste_cuda.trace_cpu(star_case.scene, *arrays)
    assert str(refusal.value) == message


@pytest.mark.parametrize(
    "origins",
    [np.zeros((3, 2), np.float32), np.zeros(6, np.float32), np.zeros((2, 3), np.complex64)],
    ids=["transposed", "flat", "complex"],
)
def test_arrays_of_another_shape_or_type_are_refused(
    star_case: Case, origins: NDArray[np.generic]
) -> None:
    with pytest.raises(TypeError, match="incompatible function arguments"):
        haste_cuda.trace_cpu(star_case.scene, origins, TOWARDS, START, END)


def test_an_unknown_intersector_is_refused(star_case: Case) -> None:
    with pytest.raises(ValueError, match="intersector must be one of embree, haste, not optix"):
        star_case.trace(intersector="optix")
