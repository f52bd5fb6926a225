"""Brute force in double precision: right where it decides, and honest where nobody can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from harness.eye_rays import corner_rays
from harness.measure.config import ROOT
from harness.scene import Scene, load_scene
from harness.tracers.rays import Rays, make_rays
from reference import pinhole
from reference.brute_force import NONE, closest_hits


@pytest.fixture(scope="module")
def template() -> Scene:
    return load_scene(ROOT / "scenes" / "cornell-box")


def of_triangles(template: Scene, corners: np.ndarray) -> Scene:
    """A scene of triangles [T, 3, 3] and nothing else."""
    triangles = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    vertices = corners.reshape(-1, 3).astype(np.float32)
    return replace(template, vertices=vertices, triangles=triangles)


def rays(origins: object, directions: object, t_max: float = np.inf) -> Rays:
    return make_rays(np.array(origins, np.float32), np.array(directions, np.float32), 0.0, t_max)


UNIT = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float)


def test_it_sees_what_the_rasteriser_of_eye_rays_sees(template: Scene):
    film = replace(
        template.camera,
        width=64,
        height=64,
        dx=tuple(np.array(template.camera.dx) * template.camera.width / 64),
        dy=tuple(np.array(template.camera.dy) * template.camera.height / 64),
    )
    scene = replace(template, camera=film)
    origins, directions = corner_rays(film)
    expected = pinhole.closest_hits(scene, origins, directions)
    found = closest_hits(scene, rays(origins, directions))
    clear = ~found.ambiguous
    assert clear.mean() > 0.98, clear.mean()
    assert np.array_equal(found.primitive[clear], expected.primitive[clear])
    hit = clear & np.isfinite(expected.t)
    assert hit.sum() > 2000
    np.testing.assert_allclose(found.t[hit], expected.t[hit], rtol=1e-12)


def test_sorting_out_by_volumes_loses_no_hit(template: Scene):
    random = np.random.default_rng(5)
    # Triangles from large to a millionth of the scene, around points that rays are aimed at.
    size = 10.0 ** random.uniform(-6.0, 0.0, (300, 1, 1))
    middle = random.uniform(-1.0, 1.0, (300, 1, 3))
    corners = (middle + size * random.normal(size=(300, 3, 3))).astype(np.float32)
    weights = random.dirichlet([2.0, 2.0, 2.0], 2000)
    aimed = np.einsum("nc,ncx->nx", weights, corners[random.integers(300, size=2000)])
    origins = random.uniform(-2.0, 2.0, (2000, 3)).astype(np.float32)
    towards = (aimed - origins).astype(np.float32)
    found = closest_hits(of_triangles(template, corners), rays(origins, towards))
    best = np.full(2000, np.inf)
    for a, b, c in corners.astype(np.float64):
        # Cramer's rule for o + t d = a + u (b - a) + v (c - a), every triangle for every ray.
        columns = np.stack(np.broadcast_arrays(b - a, c - a, -towards.astype(np.float64)), axis=-1)
        with np.errstate(all="ignore"):
            u, v, t = np.moveaxis(
                np.linalg.solve(columns, (origins.astype(np.float64) - a)[..., None])[..., 0], 1, 0
            )
        inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)
        best = np.where(inside & (t < best), t, best)
    clear = ~found.ambiguous
    assert clear.mean() > 0.5 and np.isfinite(best[clear]).mean() > 0.5
    assert np.array_equal(np.isfinite(found.t[clear]), np.isfinite(best[clear]))
    hit = clear & np.isfinite(best)
    # Systems of small triangles are ill conditioned: 1e-16 over their size.
    np.testing.assert_allclose(found.t[hit], best[hit], rtol=1e-6)


def test_a_ray_through_an_edge_or_a_corner_is_ambiguous_and_one_beside_it_is_not(template: Scene):
    scene = of_triangles(template, UNIT)
    near, far = 2.0**-24, 2.0**-12
    targets = [
        (0.5, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.5, 0.5, 0.0),
        (0.5, near, 0.0),
        (0.5, -near, 0.0),
        (0.5, far, 0.0),
        (0.5, -far, 0.0),
        (0.2, 0.2, 0.0),
    ]
    origins = [(x, y, 1.0) for x, y, _ in targets]
    found = closest_hits(scene, rays(origins, [(0.0, 0.0, -1.0)] * len(targets)))
    assert found.ambiguous.tolist() == [True] * 5 + [False] * 3
    assert np.isfinite(found.t[5:]).tolist() == [True, False, True]


def test_a_ray_that_ends_on_a_surface_is_ambiguous_and_others_are_decided(template: Scene):
    scene = of_triangles(template, UNIT)
    for t_max, hit, ambiguous in ((1.0, True, True), (0.99, False, False), (1.01, True, False)):
        found = closest_hits(scene, rays([(0.2, 0.2, 1.0)], [(0.0, 0.0, -1.0)], t_max))
        assert np.isfinite(found.t[0]) == hit, t_max
        assert found.ambiguous[0] == ambiguous, t_max


def test_what_is_doubtful_behind_a_hit_does_not_matter(template: Scene):
    behind = UNIT + np.array([0.2, 0.2, -1.0])
    scene = of_triangles(template, np.concatenate([UNIT, behind]))
    # Through the corner of the further triangle, and the middle of the nearer one.
    found = closest_hits(scene, rays([(0.2, 0.2, 1.0)], [(0.0, 0.0, -1.0)]))
    assert not found.ambiguous[0] and found.primitive[0] == 0


def test_of_two_triangles_in_one_place_the_lower_number_counts(template: Scene):
    scene = of_triangles(template, np.concatenate([UNIT, UNIT]))
    found = closest_hits(scene, rays([(0.2, 0.2, 1.0)], [(0.0, 0.0, -1.0)]))
    assert found.primitive[0] == 0 and found.t[0] == 1.0


def test_a_triangle_without_an_area_is_never_hit(template: Scene):
    line = np.array([[[0, 0, 0], [1, 0, 0], [0.5, 0, 0]], [[0.2, 0.2, 0]] * 3], float)
    found = closest_hits(of_triangles(template, line), rays([(0.5, 0, 1)], [(0, 0, -1)]))
    assert found.primitive[0] == NONE and np.isinf(found.t[0])


def test_a_sphere_is_hit_from_outside_and_inside_and_its_silhouette_is_ambiguous(template: Scene):
    scene = of_triangles(template, np.zeros((0, 3, 3)))
    scene = replace(scene, spheres=np.array([[0, 0, 0, 1]], np.float32))
    found = closest_hits(
        scene, rays([(0, 0, 3), (0, 0, 0), (1, 0, 3), (1.01, 0, 3)], [(0, 0, -2)] * 4)
    )
    np.testing.assert_allclose(found.t[:2], [1.0, 0.5], rtol=1e-12)
    assert found.ambiguous.tolist() == [False, False, True, False]
    assert np.isinf(found.t[3])
