"""No ray at an edge or a vertex of a closed mesh passes between the triangles."""

from __future__ import annotations

import numpy as np
import pytest
from core_meshes import mesh_scene, star
from numpy.typing import NDArray

import haste_cuda
from harness.stability.aims import AIMS, Mesh, aimed_rays
from harness.stability.cracks import Truth, false_hits, lost, truth_of
from harness.stability.rings import Integers, Rings, edge_rings, vertex_rings
from harness.tracers.rays import NONE, Rays
from haste_cuda import _core
from reference.exact_hits import meets

SCALES = (1e-6, 1.0, 1e6)
EYES = (1.0, 1e2, 1e3)
RAYS = 100_000
"""Of a test, over all scales, eyes and aims."""
COUNT = RAYS // (len(SCALES) * len(EYES) * len(AIMS))


def closed_mesh(scale: float) -> Mesh:
    vertices, triangles = star()
    return Mesh.of((vertices.astype(np.float64) * scale).astype(np.float32), triangles)


def aimed(mesh: Mesh, aim: str, eye: float, count: int) -> tuple[Rings, Rays, Integers, Truth]:
    rings = (edge_rings if "edge" in aim else vertex_rings)(mesh.vertices, mesh.triangles)
    random = np.random.default_rng([31, AIMS.index(aim), int(eye)])
    rays, ring = aimed_rays(mesh, rings, count, eye=eye, beside="beside" in aim, random=random)
    return rings, rays, ring, truth_of(mesh, rings, rays, ring)


def arrays(rays: Rays) -> tuple[NDArray[np.float32], ...]:
    return rays.origins, rays.directions, rays.t_min, rays.t_max


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("scale", SCALES)
def test_no_traversal_loses_a_ray_between_triangles(scale: float, eye: float) -> None:
    mesh = closed_mesh(scale)
    scene = mesh_scene(mesh.vertices, mesh.triangles)
    for aim in AIMS:
        rings, rays, ring, truth = aimed(mesh, aim, eye, COUNT)
        assert truth.covered.mean() > 0.2, f"{aim}: {truth.covered.mean():.1%} of the rays judged"
        for traversal in _core.traversals():
            found = haste_cuda.trace_cpu(scene, *arrays(rays), traversal=traversal)
            gone = lost(rings, ring, truth, found["t"], found["primitive"]) & truth.covered
            first = int(np.argmax(gone))
            assert not gone.any(), (
                f"{traversal}, scale {scale:g}, eye {eye:g}, aimed at {aim}: {gone.sum()} of "
                f"{truth.covered.sum()} rays, the first {rays.origins[first].tolist()} towards "
                f"{rays.directions[first].tolist()}"
            )
            wrong = false_hits(mesh, rays, found["t"], found["primitive"])
            assert not wrong.any(), f"{traversal}, {aim}: {wrong.sum()} hits beside the triangles"
            until = (rays.origins, rays.directions, rays.t_min, truth.end.astype(np.float32))
            some = haste_cuda.trace_cpu(scene, *until, traversal=traversal, any_hit=True)
            assert np.isfinite(some["t"][truth.covered]).all(), f"{traversal}, {aim}: any hit"


@pytest.mark.parametrize("eye", EYES)
def test_a_test_that_is_not_watertight_is_caught(eye: float) -> None:
    """Negative control: Embree's fast test has rounding of its own for each triangle."""
    mesh = closed_mesh(1.0)
    scene = mesh_scene(mesh.vertices, mesh.triangles)
    for aim in AIMS:
        rings, rays, ring, truth = aimed(mesh, aim, eye, COUNT)
        found = haste_cuda.trace_embree(scene, *arrays(rays), mode="fast")
        gone = lost(rings, ring, truth, found["t"], found["primitive"]) & truth.covered
        assert gone.any(), f"eye {eye:g}, {aim}: none of {truth.covered.sum()} rays is lost"


def test_a_crack_of_one_ulp_is_caught() -> None:
    """Negative control: a vertex is moved by an ulp in every second of its triangles."""
    mesh = closed_mesh(1.0)
    moved = mesh.vertices + np.spacing(mesh.vertices)
    corners = np.concatenate([mesh.vertices, moved.astype(np.float32)])
    triangles = mesh.triangles.copy()
    triangles[::2] += np.uint32(len(mesh.vertices))
    scene = mesh_scene(corners, triangles)
    rings, rays, ring, truth = aimed(mesh, "edge", 1.0, 20_000)
    found = haste_cuda.trace_cpu(scene, *arrays(rays))
    assert (lost(rings, ring, truth, found["t"], found["primitive"]) & truth.covered).any()


def test_missing_triangles_are_caught_and_nothing_else_is() -> None:
    """Negative control."""
    mesh = closed_mesh(1.0)
    missing = np.arange(len(mesh.triangles)) % 100 == 50
    scene = mesh_scene(mesh.vertices, mesh.triangles[~missing])
    rings, rays, ring, truth = aimed(mesh, "beside_edge", 1.0, 20_000)
    found = haste_cuda.trace_cpu(scene, *arrays(rays))
    number = np.append(np.flatnonzero(~missing), NONE).astype(np.uint32)
    primitive = number[np.minimum(found["primitive"], len(number) - 1)]
    gone = lost(rings, ring, truth, found["t"], primitive) & truth.covered
    beside = missing[rings.triangle.reshape(-1, 2)[ring]].any(axis=1)
    assert gone.any() and not (gone & ~beside).any()


def test_a_hit_of_another_triangle_is_denied() -> None:
    """Negative control of what is called a false hit."""
    mesh = closed_mesh(1.0)
    scene = mesh_scene(mesh.vertices, mesh.triangles)
    _, rays, _, _ = aimed(mesh, "edge", 1.0, 5000)
    found = haste_cuda.trace_cpu(scene, *arrays(rays))
    hit = np.isfinite(found["t"])
    away = (found["primitive"] + 7) % len(mesh.triangles)
    assert false_hits(mesh, rays, found["t"], away.astype(np.uint32))[hit].mean() > 0.9
    farther = found["t"] * np.float32(1 + 2.0**-12)
    assert false_hits(mesh, rays, farther, found["primitive"])[hit].mean() > 0.9


@pytest.mark.parametrize("aim", AIMS)
def test_what_the_rim_covers_is_met_exactly(aim: str) -> None:
    mesh = closed_mesh(1.0)
    for eye in EYES:
        rings, rays, ring, truth = aimed(mesh, aim, eye, 5000)
        place, begin = rings.pairs_of(ring)
        ray = np.repeat(np.arange(len(rays)), np.diff(begin))
        corners = mesh.vertices[mesh.triangles[rings.triangle[place]]]
        exact = meets(corners, rays.origins[ray], rays.directions[ray])
        met = np.logical_or.reduceat(exact, begin[:-1])
        assert (met == truth.met).all()
        assert (met | ~truth.covered).all()
        assert (met & ~truth.covered).any(), "some rays are at an outline"


def test_rings_of_a_closed_mesh_are_all_its_edges_and_vertices() -> None:
    vertices, triangles = star(6)
    edges, corners = edge_rings(vertices, triangles), vertex_rings(vertices, triangles)
    assert len(edges) == 3 * len(triangles) // 2
    assert len(corners) == len(vertices)
    assert len(edges.triangle) == len(corners.triangle) == 3 * len(triangles)


def test_rings_at_a_boundary_and_at_a_fold_are_left_out() -> None:
    vertices, triangles = star(6)
    whole = len(vertex_rings(vertices, triangles))
    opened = triangles[1:]
    assert len(edge_rings(vertices, opened)) == 3 * len(triangles) // 2 - 3
    assert len(vertex_rings(vertices, opened)) == whole - 3
    turned = triangles.copy()
    turned[0] = turned[0, ::-1]
    assert len(edge_rings(vertices, turned)) == 3 * len(triangles) // 2 - 3
    assert len(vertex_rings(vertices, turned)) == whole - 3


def test_rings_do_not_see_that_a_mesh_has_its_corners_twice() -> None:
    vertices, triangles = star(6)
    loose = vertices[triangles].reshape(-1, 3)
    separate = np.arange(len(loose), dtype=np.uint32).reshape(-1, 3)
    assert len(edge_rings(loose, separate)) == 3 * len(triangles) // 2
    assert len(vertex_rings(loose, separate)) == len(vertices)
