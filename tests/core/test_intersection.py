"""Traversal, triangles, spheres and the starts of spawned rays."""

from __future__ import annotations

import numpy as np
import pytest
from core_meshes import Triangles, Vertices, directions, mesh_scene, star
from haste_cuda._core import testing
from numpy.typing import NDArray

import haste_cuda

MISS = 0xFFFFFFFF


def edge_targets(
    vertices: Vertices, triangles: Triangles, count: int, seed: int
) -> NDArray[np.float64]:
    """Points on edges, half of them moved by up to 4 ulp."""
    random = np.random.default_rng(seed)
    triangle = triangles[random.integers(0, len(triangles), count)]
    corner = random.integers(0, 3, count)
    row = np.arange(count)
    a = vertices[triangle[row, corner]].astype(np.float64)
    b = vertices[triangle[row, (corner + 1) % 3]].astype(np.float64)
    s = random.random((count, 1))
    moved = random.integers(-4, 5, (count, 3)) * (row % 2)[:, None]
    point = (a + s * (b - a)).astype(np.float32)
    return point.astype(np.float64) + moved * np.spacing(np.abs(point)).astype(np.float64)


def rays_at(
    targets: NDArray[np.float64], distance: float, seed: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Rays from `distance` away: origins outside the mesh, directions rounded to float32."""
    away = directions(len(targets), seed).astype(np.float64)
    origins = (distance * away).astype(np.float32)
    towards = targets - origins
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    return origins, towards.astype(np.float32)


def missed(
    scene: haste_cuda.Scene, origins: NDArray[np.float32], towards: NDArray[np.float32]
) -> int:
    return int((testing.closest(scene, origins, towards)[2] == MISS).sum())


@pytest.mark.parametrize("scale", [2.0**-20, 1.0, 2.0**20])
def test_no_ray_from_inside_a_closed_mesh_finds_a_crack(scale: float) -> None:
    vertices, triangles = star()
    vertices = vertices * np.float32(scale)
    scene = mesh_scene(vertices, triangles)
    count = 100_000
    aims = {
        "edges": edge_targets(vertices, triangles, count, 2),
        "vertices": vertices[np.random.default_rng(3).integers(0, len(vertices), count)].astype(
            np.float64
        ),
    }
    for name, targets in aims.items():
        towards = targets / np.linalg.norm(targets, axis=1, keepdims=True)
        origins = np.zeros((count, 3), np.float32)
        misses = missed(scene, origins, towards.astype(np.float32))
        assert misses == 0, f"scale {scale:g}, aimed at {name}: {misses} of {count} rays escape"


def test_a_missing_triangle_is_found_by_the_same_rays() -> None:
    vertices, triangles = star()
    scene = mesh_scene(vertices, triangles[1:])
    targets = edge_targets(vertices, triangles, 100_000, 2)
    towards = (targets / np.linalg.norm(targets, axis=1, keepdims=True)).astype(np.float32)
    assert missed(scene, np.zeros((100_000, 3), np.float32), towards) > 0


def brute_force(
    vertices: Vertices,
    triangles: Triangles,
    origins: NDArray[np.float32],
    towards: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Closest t in double precision by Moeller and Trumbore's test over all triangles."""
    v = vertices.astype(np.float64)[triangles]
    e1, e2 = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    best = np.full(len(origins), np.inf)
    for i, (o, d) in enumerate(
        zip(origins.astype(np.float64), towards.astype(np.float64), strict=True)
    ):
        p = np.cross(d, e2)
        determinant = (e1 * p).sum(-1)
        s = o - v[:, 0]
        q = np.cross(s, e1)
        with np.errstate(all="ignore"):
            u = (s * p).sum(-1) / determinant
            w = (d * q).sum(-1) / determinant
            t = (e2 * q).sum(-1) / determinant
        inside = (u >= -1e-9) & (w >= -1e-9) & (u + w <= 1 + 1e-9) & (t > 0)
        if inside.any():
            best[i] = t[inside].min()
    return best


def test_the_hierarchy_finds_what_brute_force_in_double_precision_finds() -> None:
    vertices, triangles = star(12)
    scene = mesh_scene(vertices, triangles)
    targets = np.random.default_rng(5).uniform(-0.9, 0.9, (3000, 3))
    origins, towards = rays_at(targets, 3.0, 6)
    t = testing.closest(scene, origins, towards)[0].astype(np.float64)
    truth = brute_force(vertices, triangles, origins, towards)
    assert (np.isfinite(t) == np.isfinite(truth)).mean() > 0.999
    both = np.isfinite(t) & np.isfinite(truth)
    # A silhouette may be seen on either side by the two; elsewhere t carries a few roundings on
    # coordinates of size 4, over the cosine of incidence.
    close = np.abs(t[both] - truth[both]) <= 1e-4
    assert close.mean() > 0.999, f"{(~close).sum()} of {both.sum()} rays differ"


def test_embree_and_the_hierarchy_agree() -> None:
    vertices, triangles = star()
    scene = mesh_scene(vertices, triangles, [(0, 0, 2, 0.5), (2, 0, 0, 0.25)])
    targets = np.random.default_rng(7).uniform(-1.5, 1.5, (50_000, 3))
    origins, towards = rays_at(targets, 4.0, 8)
    ours = testing.closest(scene, origins, towards)
    theirs = testing.closest(scene, origins, towards, intersector="embree")
    differ = ours[2] != theirs[2]
    # Rays at silhouettes and shared edges may choose either neighbour.
    assert differ.mean() < 5e-5, f"{differ.sum()} of {len(differ)} rays differ"
    hit = ~differ & (ours[2] != MISS)
    assert np.abs(ours[0][hit] - theirs[0][hit]).max() < 1e-4


def test_axis_parallel_rays_from_box_faces_miss_nothing() -> None:
    # A flat grid in z = 0 whose cells the hierarchy's boxes bound exactly: origins on the slabs.
    n = 16
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    vertices = np.stack([x, y, 0 * x], -1).reshape(-1, 3).astype(np.float32)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.vstack(
        [np.stack([a, a + 1, a + n + 2], -1), np.stack([a, a + n + 2, a + n + 1], -1)]
    )
    scene = mesh_scene(vertices, triangles.astype(np.uint32))
    for zero in (0.0, -0.0):
        origins = vertices + np.array([0, 0, 5], np.float32)
        towards = np.tile(np.array([[zero, zero, -1]], np.float32), (len(origins), 1))
        t, _, primitive = testing.closest(scene, origins, towards)
        assert (primitive != MISS).all() and (t == 5).all(), f"d = ({zero}, {zero}, -1)"


def test_the_tree_is_the_same_at_any_number_of_threads() -> None:
    vertices, triangles = star(96)
    hashes = {mesh_scene(vertices, triangles, threads=n).bvh["sha256"] for n in (1, 2, 1, 2)}
    assert len(hashes) == 1, f"{len(triangles)} triangles gave {len(hashes)} trees"


def test_degenerate_triangles_are_never_hit_and_do_not_hide_their_neighbours() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [0.5, 0.5, 1]], np.float32)
    triangles = np.array([[0, 1, 3], [4, 4, 4], [0, 1, 1], [0, 1, 2]], np.uint32)
    scene = mesh_scene(vertices, triangles)
    origins = np.array([[0.25, 0.25, 3], [0.5, 0.5, 3], [0.5, 0, 3], [1.5, 0, 3]], np.float32)
    towards = np.tile(np.array([[0, 0, -1]], np.float32), (4, 1))
    primitive = testing.closest(scene, origins, towards)[2]
    assert list(primitive) == [3, 3, 3, MISS]


@pytest.mark.parametrize("distance", [10.0, 1e3, 1e4])
def test_spheres_far_away_are_hit_where_double_precision_hits_them(distance: float) -> None:
    scene = mesh_scene(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32), [(0, 0, 0, 1)])
    random = np.random.default_rng(9)
    targets = random.normal(size=(20_000, 3))
    targets *= random.uniform(0, 1.2, (20_000, 1)) / np.linalg.norm(targets, axis=1, keepdims=True)
    origins, towards = rays_at(targets, distance, 10)
    t, _, primitive = testing.closest(scene, origins, towards)
    o, d = origins.astype(np.float64), towards.astype(np.float64)
    b = (o * d).sum(-1) / (d * d).sum(-1)
    height = np.linalg.norm(o - b[:, None] * d, axis=1)
    # The origin's own rounding moves the ray by u * distance: nearer the edge either is right.
    clear = np.abs(height - 1) > 4 * 2.0**-24 * distance
    wrong = (primitive[clear] != MISS) != (height[clear] < 1)
    assert not wrong.any(), f"distance {distance:g}: {wrong.sum()} of {clear.sum()}"
    hit = clear & (height < 1)
    truth = -b[hit] - np.sqrt(1 - height[hit] ** 2)
    # An error of the height is magnified by the slope of the sphere at the silhouette.
    slope = 1 / np.sqrt(1 - height[hit] ** 2)
    bound = 8 * 2.0**-24 * distance * (1 + slope)
    assert (np.abs(t[hit] - truth) <= bound).all()


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_spawned_rays_never_hit_the_flat_surface_they_leave(scale: float) -> None:
    # A quad of two triangles at a random orientation: the ray must leave its own triangle and the
    # coplanar neighbour alone, at grazing angles too.
    random = np.random.default_rng(11)
    for trial in range(20):
        frame = np.linalg.qr(random.normal(size=(3, 3)))[0]
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) @ frame.T
        # Its own size from the origin: the bound is relative to the coordinates.
        vertices = ((corners + frame[:, 0] * random.uniform(-1, 1)) * scale).astype(np.float32)
        scene = mesh_scene(vertices, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
        count = 2000
        weights = random.dirichlet((1, 1, 1, 1), count)
        targets = weights @ vertices.astype(np.float64)
        normal = frame[:, 2]
        origins = (targets + normal * scale * random.uniform(1, 3, (count, 1))).astype(np.float32)
        towards = targets - origins
        towards = (towards / np.linalg.norm(towards, axis=1, keepdims=True)).astype(np.float32)
        height = 10.0 ** random.uniform(-4, 0, (count, 1)) * random.choice([-1, 1], (count, 1))
        along = random.normal(size=(count, 2)) @ frame[:, :2].T
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        next_directions = along * np.sqrt(1 - np.minimum(height**2, 1)) + normal * height
        next_directions = (
            next_directions / np.linalg.norm(next_directions, axis=1, keepdims=True)
        ).astype(np.float32)
        points, _, starts = testing.spawn(scene, origins, towards, next_directions)
        again = testing.closest(scene, starts, next_directions)[2] != MISS
        # The quad itself is flat only to the rounding of its vertices; rays flatter than that may
        # truly cross it again.
        assert not again.any(), (
            f"scale {scale:g}, trial {trial}: {again.sum()} of {count} hit again"
        )
        offset = np.abs(starts - points).max() / np.abs(vertices).max()
        assert offset <= 2e-6, f"scale {scale:g}: offset {offset:.2g} of the largest coordinate"


def test_spawned_rays_never_hit_the_sphere_they_leave() -> None:
    random = np.random.default_rng(13)
    for radius in (1e-3, 1.0, 1e3):
        centre = random.uniform(-2, 2, 3) * radius
        scene = mesh_scene(
            np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32), [(*centre, radius)]
        )
        count = 5000
        outward = directions(count, 14).astype(np.float64)
        targets = np.float32(centre) + outward * radius
        origins = (targets + outward * radius).astype(np.float32)
        towards = (-outward).astype(np.float32)
        leaving = directions(count, 15).astype(np.float64)
        leaving *= np.sign((leaving * outward).sum(-1, keepdims=True))
        leaving = leaving.astype(np.float32)
        _, _, starts = testing.spawn(scene, origins, towards, leaving)
        again = testing.closest(scene, starts, leaving)[2] != MISS
        assert not again.any(), f"radius {radius:g}: {again.sum()} of {count} hit again"


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_an_occluder_just_above_a_floor_lets_no_light_through(scale: float) -> None:
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    gap = 1e-5
    vertices = (np.vstack([square, square * 0.9 + [0, 0, gap]]) * scale).astype(np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.uint32)
    scene = mesh_scene(vertices, triangles)
    targets = np.random.default_rng(17).uniform(-0.8, 0.8, (5000, 2)) * scale
    origins = np.column_stack([targets, np.full(5000, -scale)]).astype(np.float32)
    up = np.tile(np.array([[0, 0, 1]], np.float32), (5000, 1))
    _, _, starts = testing.spawn(scene, origins, up, up)
    to_light = (up * np.float32(5 * scale)).astype(np.float32)
    blocked = testing.occluded(scene, starts, to_light)
    assert blocked.all(), f"scale {scale:g}: {(blocked == 0).sum()} of 5000 rays leak"


def test_the_owning_shape_never_blocks_and_every_other_does() -> None:
    scene = mesh_scene(
        np.array([[-1, -1, 1], [1, -1, 1], [0, 1, 1]], np.float32),
        np.array([[0, 1, 2]], np.uint32),
        [(0, 0, 3, 0.5)],
    )
    origin, up = np.zeros((1, 3), np.float32), np.array([[0, 0, 4]], np.float32)
    for intersector in ("haste", "embree"):
        assert testing.occluded(scene, origin, up, owner=0, intersector=intersector)[0], intersector
        assert testing.occluded(scene, origin, up, owner=1, intersector=intersector)[0], intersector
        just_below = up * np.float32(0.24)
        assert not testing.occluded(scene, origin, just_below, intersector=intersector)[0], (
            intersector
        )
        above = np.array([[0, 0, 2]], np.float32)
        assert not testing.occluded(scene, above, up, owner=1, intersector=intersector)[0], (
            intersector
        )


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (np.array([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], np.float32), "vertex 2"),
        (np.array([[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]], np.float32), "vertex 1"),
    ],
)
def test_a_vertex_that_is_not_finite_is_refused_by_its_number(
    vertices: Vertices, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        mesh_scene(vertices, np.array([[0, 1, 2]], np.uint32))


def test_an_index_out_of_range_is_refused_by_its_place() -> None:
    with pytest.raises(ValueError, match=r"triangles\[2\] = 7"):
        mesh_scene(np.eye(3, dtype=np.float32), np.array([[0, 1, 7]], np.uint32))


def test_an_empty_scene_is_refused() -> None:
    with pytest.raises(ValueError, match="no triangle and no sphere"):
        mesh_scene(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32))


def test_importing_the_extension_leaves_denormal_numbers_alone() -> None:
    assert haste_cuda.__doc__ and np.finfo(float).smallest_subnormal > 0
