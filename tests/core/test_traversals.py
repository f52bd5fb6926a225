"""Every traversal finds what testing every primitive finds, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from core_meshes import Triangles, Vertices, directions, mesh_scene, star
from numpy.typing import NDArray

import haste_cuda
from haste_cuda import _core

TRAVERSALS = _core.traversals()
Rays = tuple[NDArray[np.float32], ...]
Spheres = list[tuple[float, float, float, float]]
NODE = np.dtype(
    [
        ("origin", "<f4", 3),
        ("exponent", "u1", 3),
        ("inner", "u1"),
        ("first_child", "<u4"),
        ("first_primitive", "<u4"),
        ("primitives", "<u4"),
        ("offset", "<f4"),
        ("lower", "u1", (3, 8)),
        ("upper", "u1", (3, 8)),
    ]
)


def needles(count: int, seed: int) -> tuple[Vertices, Triangles]:
    """Triangles 1e5 times as long as wide, in three planes and of any direction in them."""
    random = np.random.default_rng(seed)
    foot = random.random((count, 3))
    foot[:, 2] = random.integers(0, 3, count)
    angle = random.uniform(0, 2 * np.pi, count)
    along = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], -1)
    across = 1e-5 * np.stack([-np.sin(angle), np.cos(angle), np.zeros(count)], -1)
    vertices = np.stack([foot, foot + along, foot + along + across], 1)
    return vertices.reshape(-1, 3).astype(np.float32), np.arange(3 * count).reshape(-1, 3)


def soup(count: int, seed: int) -> tuple[Vertices, Triangles]:
    """Triangles of all sizes, every tenth of them without an area, every seventh there twice."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-5, 0, (count, 1, 1))
    vertices = random.normal(size=(count, 1, 3)) + size * random.normal(size=(count, 3, 3))
    vertices[::10, 2] = vertices[::10, 1]
    copies = vertices[1::7]
    vertices[: 7 * len(copies) : 7] = copies
    return vertices.reshape(-1, 3).astype(np.float32), np.arange(3 * count).reshape(-1, 3)


def grid() -> tuple[Vertices, Triangles]:
    """A flat square of 800 triangles: its boxes have no extent along z."""
    x, y = np.meshgrid(np.arange(21), np.arange(21), indexing="ij")
    vertices = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3) / 20
    a = (21 * np.arange(20)[:, None] + np.arange(20)).ravel()
    triangles = np.concatenate(
        [np.stack([a, a + 21, a + 22], -1), np.stack([a, a + 22, a + 1], -1)]
    )
    return vertices.astype(np.float32), triangles


def rays_at(vertices: Vertices, triangles: Triangles, count: int, seed: int) -> Rays:
    """Rays at vertices, edges and interiors, at nothing in particular and along the axes, from near
    and far; half of them with an interval of their own."""
    random = np.random.default_rng(seed)
    corners = vertices[triangles[random.integers(0, len(triangles), count)]].astype(np.float64)
    weights = random.dirichlet(np.ones(3), count)
    weights[::4] = [1, 0, 0]
    weights[1::4, 2] = 0
    weights /= weights.sum(axis=1, keepdims=True)
    targets = (weights[:, :, None] * corners).sum(axis=1)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = np.linalg.norm(high - low)
    far = random.choice([0.0, 0.3, 2.0, 1e3], (count, 1))
    origins = (low + high) / 2 + size * far * directions(count, seed + 1)
    origins[::7] = random.uniform(low, high, (len(origins[::7]), 3))
    towards = targets.astype(np.float32) - origins.astype(np.float32)
    axis = np.eye(3)[random.integers(0, 3, count)] * random.choice([-1, 1], (count, 1))
    along = np.arange(count) % 5 == 0
    towards[along] = axis[along]
    origins[along] = (targets - size * axis)[along]
    towards[~towards.any(axis=1)] = 1
    t_min = np.where(random.random(count) < 0.5, 0.0, random.uniform(0, 0.9, count))
    t_max = np.where(random.random(count) < 0.5, np.inf, t_min + random.uniform(0, 2, count))
    return tuple(array.astype(np.float32) for array in (origins, towards, t_min, t_max))


IDENTICAL = (np.eye(3, dtype=np.float32), np.tile(np.arange(3), (10_000, 1)))
NO_MESH = (np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int64))
BALLS: Spheres = [
    (float(x), float(y), float(z), float(r))
    for x, y, z, r in np.random.default_rng(3).uniform([-2, -2, -2, 0.01], [2, 2, 2, 0.4], (60, 4))
]
CASES: dict[str, tuple[tuple[Vertices, Triangles], Spheres, int]] = {
    "star": (star(12), [], 20_000),
    "far from the origin": ((star(12)[0] + np.float32(1000), star(12)[1]), [], 10_000),
    "soup": (soup(1500, 1), [], 20_000),
    "needles": (needles(1000, 2), [], 20_000),
    "flat": (grid(), [], 20_000),
    "identical": (IDENTICAL, [], 300),
    "one": ((np.eye(3, dtype=np.float32), np.arange(3)[None]), [], 2000),
    "spheres": (NO_MESH, BALLS, 20_000),
    "both": (star(8), BALLS, 20_000),
}


@pytest.mark.parametrize("name", CASES)
def test_all_traversals_find_the_same_bit_for_bit(name: str) -> None:
    (vertices, triangles), spheres, count = CASES[name]
    scene = mesh_scene(vertices, triangles, spheres)
    aims = (vertices, triangles) if len(triangles) else star(8)
    rays = rays_at(*aims, count, 40)
    truth = haste_cuda.trace_cpu(scene, *rays, traversal="brute_force")
    hit = np.isfinite(truth["t"])
    assert 0.05 < hit.mean() < 1.0, f"{hit.mean():.1%} of the rays hit"
    for traversal in TRAVERSALS:
        found = haste_cuda.trace_cpu(scene, *rays, traversal=traversal)
        wrong = (found["t"] != truth["t"]) | (found["primitive"] != truth["primitive"])
        first = int(np.argmax(wrong))
        assert not wrong.any(), (
            f"{traversal}: {wrong.sum()} of {count} rays, the first {first}: "
            f"{[array[first].tolist() for array in rays]}: t {found['t'][first]!r}, primitive "
            f"{found['primitive'][first]}, not {truth['t'][first]!r}, {truth['primitive'][first]}"
        )
        some = haste_cuda.trace_cpu(scene, *rays, traversal=traversal, any_hit=True)
        assert (np.isfinite(some["t"]) == hit).all(), traversal


def decoded(node: np.void, slot: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The box of a child, exactly: the scenes here are such that doubles hold its planes."""
    step = 2.0 ** (node["exponent"].astype(np.float64) - 127)
    origin = node["origin"].astype(np.float64)
    lower, upper = node["lower"][:, slot] + 2.0**15, node["upper"][:, slot] + 2.0**15
    return origin + step * lower, origin + step * upper


def covered(
    scene: haste_cuda.Scene, points: NDArray[np.float64], owner: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which points lie in boxes all the way from the root to a leaf that holds their primitive."""
    nodes, order = _core.testing.bvh8_nodes(scene)
    nodes = nodes.view(NODE)[:, 0]
    found = np.zeros(len(points), bool)
    waiting = [(0, np.arange(len(points)))]
    visited = 0
    while waiting:
        index, inside = waiting.pop()
        visited += 1
        node = nodes[index]
        child = int(node["first_child"])
        primitive = int(node["first_primitive"])
        for slot in range(8):
            low, high = decoded(node, slot)
            held = inside[((points[inside] >= low) & (points[inside] <= high)).all(axis=1)]
            count = (int(node["primitives"]) >> (3 * slot) & 7).bit_count()
            inner = int(node["inner"]) >> slot & 1
            assert not (inner and count), "a slot holds a node or a leaf"
            if inner:
                waiting.append((child, held))
                child += 1
            if count:
                own = order[primitive : primitive + count]
                found[held[np.isin(owner[held], own)]] = True
                primitive += count
    assert visited == len(nodes)
    return found


@pytest.mark.parametrize("name", ["star", "soup", "needles", "flat", "one"])
def test_decoded_boxes_contain_their_triangles(name: str) -> None:
    """Vertices, and points of edges and interiors: spatial splits clip a triangle's boxes."""
    (vertices, triangles), _, _ = CASES[name]
    weights = np.concatenate([np.eye(3), np.random.default_rng(5).dirichlet(np.ones(3), 20)])
    weights[3:9, 0] = 0
    weights /= weights.sum(axis=1, keepdims=True)
    corners = vertices[triangles].astype(np.float64)
    points = np.einsum("wk,tkc->twc", weights, corners).reshape(-1, 3)
    owner = np.repeat(np.arange(len(triangles)), len(weights))
    inside = covered(mesh_scene(vertices, triangles), points, owner)
    assert inside.all(), f"{(~inside).sum()} of {len(inside)} points lie outside"


def test_decoded_boxes_contain_their_spheres() -> None:
    balls = np.array(BALLS, np.float32).astype(np.float64)
    surface = directions(200, 9).astype(np.float64)
    surface[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    points = (balls[:, None, :3] + balls[:, None, 3:] * surface).reshape(-1, 3)
    owner = np.repeat(np.arange(len(balls)), len(surface))
    assert covered(mesh_scene(*NO_MESH, BALLS), points, owner).all()


def test_points_outside_of_a_triangle_are_not_all_covered() -> None:
    """Negative control: the boxes are not simply large."""
    (vertices, triangles), _, _ = CASES["star"]
    points = vertices[triangles].astype(np.float64).mean(axis=1) * 1.2
    inside = covered(mesh_scene(vertices, triangles), points, np.arange(len(triangles)))
    assert inside.mean() < 0.5


def test_the_compressed_hierarchy_is_small_and_shallow() -> None:
    vertices, triangles = star(60)
    scene = mesh_scene(vertices, triangles)
    assert _core.bvh_bytes(scene, "bvh8") / len(triangles) <= 70
    assert _core.bvh_bytes(scene, "bvh8") < _core.bvh_bytes(scene, "bvh2")
    assert _core.bvh_bytes(scene, "brute_force") == 0
    assert _core.bvh_build_seconds(scene, "bvh8") > 0


def test_the_compressed_hierarchy_is_the_same_at_any_number_of_threads() -> None:
    vertices, triangles = star(30)
    one, two = (mesh_scene(vertices, triangles, threads=threads) for threads in (1, 2))
    for a, b in zip(_core.testing.bvh8_nodes(one), _core.testing.bvh8_nodes(two), strict=True):
        assert np.array_equal(a, b)


def test_wider_and_deeper_hierarchies_visit_less() -> None:
    vertices, triangles = star(40)
    scene = mesh_scene(vertices, triangles)
    rays = rays_at(vertices, triangles, 2000, 8)
    visited = {
        traversal: haste_cuda.trace_cpu(scene, *rays, traversal=traversal, count=True)
        for traversal in TRAVERSALS
    }
    assert visited["brute_force"]["triangles"] == len(triangles)
    assert visited["brute_force"]["nodes"] == 0
    for traversal in ("bvh2", "bvh2_stackless", "bvh8"):
        assert 0 < visited[traversal]["triangles"] < 0.01 * len(triangles), traversal
    assert visited["bvh8"]["nodes"] < 0.5 * visited["bvh2"]["nodes"]
    assert visited["bvh2"]["nodes"] < visited["bvh2_stackless"]["nodes"]


def test_every_repeat_is_timed_and_counting_is_not_among_them() -> None:
    vertices, triangles = star(8)
    scene = mesh_scene(vertices, triangles)
    rays = rays_at(vertices, triangles, 100, 8)
    assert len(haste_cuda.trace_cpu(scene, *rays, repeats=3, count=True)["seconds"]) == 3
    with pytest.raises(ValueError, match="repeats must be at least 1"):
        haste_cuda.trace_cpu(scene, *rays, repeats=0)
    with pytest.raises(ValueError, match="Embree does not count"):
        haste_cuda.trace_cpu(scene, *rays, intersector="embree", count=True)
    with pytest.raises(ValueError, match=r"traversal must be one of brute_force, bvh2, .* not kd"):
        haste_cuda.trace_cpu(scene, *rays, traversal="kd")
