"""The rays of the benchmark: where they start, where they go, and that they are always the same.

What they hit is found by brute force in double precision, which shares nothing with the tracers.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from harness.measure.config import ROOT
from harness.rays.classes import CLASSES
from harness.rays.generate import RaysError, extent, generate_rays, scene_box
from harness.rays.parts import PART
from harness.rays.store import hash_file, read_rays, write_rays
from harness.scene import Scene, load_scene
from harness.tracers.rays import NONE, RayHits, Rays
from reference.brute_force import closest_hits

COUNT = 4096
FOUR_SIGMA = 4.0


def brute_force(scene: Scene, rays: Rays) -> RayHits:
    truth = closest_hits(scene, rays)
    nowhere = np.full(len(rays), NONE)
    return RayHits(truth.t.astype(np.float32), nowhere, truth.primitive, (0.0,))


@cache
def scene_of(name: str) -> Scene:
    return load_scene(ROOT / "scenes" / name)


@cache
def rays_of(name: str, seed: int = 0, *, inside: bool = False) -> dict[str, Rays]:
    scene = scene_of(name)
    return generate_rays(
        scene, lambda rays: brute_force(scene, rays), COUNT, seed=seed, inside=inside
    )


def starts_of(name: str) -> tuple[NDArray[np.uint32], NDArray[np.float64]]:
    """Primitive that each secondary ray of the first generation starts from, and its normal."""
    scene, camera = scene_of(name), rays_of(name)["camera"]
    hits = brute_force(scene, camera)
    found = np.flatnonzero(hits.hit)
    ray = found[np.arange(COUNT) * len(found) // COUNT]
    corners = scene.vertices[scene.triangles[hits.primitive[ray]]].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    towards = np.einsum("ij,ij->i", normal, camera.directions[ray].astype(np.float64))
    return hits.primitive[ray], np.where(towards[:, None] > 0.0, -normal, normal)


def test_there_are_as_many_rays_of_each_class_as_were_asked_for():
    rays = rays_of("cornell-box")
    assert list(rays) == list(CLASSES)
    assert {len(one) for one in rays.values()} == {COUNT}
    for name, one in rays.items():
        assert (one.t_min == 0.0).all() and one.origins.dtype == np.float32, name
        lengths = np.linalg.norm(one.directions.astype(np.float64), axis=1)
        if name != "shadow":
            # Three components rounded to float32.
            np.testing.assert_allclose(lengths, 1.0, rtol=2.0**-22, err_msg=name)


def test_the_same_seed_gives_the_same_file_and_another_seed_others(tmp_path: Path):
    scene = scene_of("cornell-box")
    again = generate_rays(scene, lambda rays: brute_force(scene, rays), COUNT)
    other = rays_of("cornell-box", 1)
    hashes = []
    for index, rays in enumerate((rays_of("cornell-box"), again, other)):
        path = tmp_path / f"{index}.npz"
        write_rays(path, rays)
        hashes.append(hash_file(path))
    assert hashes[0] == hashes[1] != hashes[2]
    kept = read_rays(tmp_path / "0.npz", "diffuse2")
    for part in Rays.__slots__:
        assert np.array_equal(getattr(kept, part), getattr(again["diffuse2"], part)), part
    with pytest.raises(KeyError, match="caustic"):
        read_rays(tmp_path / "0.npz", "caustic")


@pytest.mark.parametrize("name", ["cornell-box", "mirror-glass"])
def test_rays_depend_on_no_number_of_threads(name: str):
    scene, count = scene_of(name), 2 * PART + 1000
    primitives = len(scene.triangles) + len(scene.spheres)

    def trace(rays: Rays) -> RayHits:
        """A tracer that is quick: each ray hits another primitive, and every third one nothing."""
        number = np.arange(len(rays), dtype=np.uint32)
        miss = number % 3 == 0
        t = np.where(miss, np.float32(np.inf), np.float32(1.0))
        nowhere = np.full(len(rays), NONE)
        return RayHits(t, nowhere, np.where(miss, NONE, number % np.uint32(primitives)), (0.0,))

    one, four = (generate_rays(scene, trace, count, threads=threads) for threads in (1, 4))
    for kind in CLASSES:
        for part in Rays.__slots__:
            a, b = getattr(one[kind], part), getattr(four[kind], part)
            assert np.array_equal(a, b), (name, kind, part)


def test_a_spawned_ray_never_meets_the_triangle_that_it_starts_from():
    scene, rays = scene_of("cornell-box"), rays_of("cornell-box")
    own, _ = starts_of("cornell-box")
    for name in ("diffuse1", "ambient"):
        met = brute_force(scene, rays[name]).primitive
        assert not np.flatnonzero(met == own).size, (name, np.flatnonzero(met == own)[:5])
    # Shadow rays start from some of the points only: what they meet is not where they start.
    hits = brute_force(scene, rays["shadow"])
    way = hits.t * np.linalg.norm(rays["shadow"].directions, axis=1)
    near = np.flatnonzero(way < 2.0**-16 * extent(scene))
    assert hits.hit.any() and not near.size, (near[:5], way[near[:5]])


def test_diffuse_rays_are_distributed_as_the_cosine():
    rays, (_, normal) = rays_of("cornell-box"), starts_of("cornell-box")
    for name in ("diffuse1", "ambient"):
        cosine = np.einsum("ij,ij->i", rays[name].directions.astype(np.float64), normal)
        assert cosine.min() > -(2.0**-20), name
        # The density 2 c of a cosine c has the mean 2/3, the mean square 1/2, the variance 1/18.
        error = abs(cosine.mean() - 2.0 / 3.0)
        assert error < FOUR_SIGMA * (1.0 / 18.0 / COUNT) ** 0.5, (name, error)
        # c^2 is uniform in [0, 1], whose variance is 1/12.
        error = abs((cosine**2).mean() - 0.5)
        assert error < FOUR_SIGMA * (1.0 / 12.0 / COUNT) ** 0.5, (name, error)


def test_ambient_rays_end_at_a_tenth_of_the_extent_and_the_others_do_not():
    rays = rays_of("cornell-box")
    reach = np.float32(0.1 * extent(scene_of("cornell-box")))
    assert (rays["ambient"].t_max == reach).all()
    for name in set(CLASSES) - {"ambient", "shadow"}:
        assert np.isinf(rays[name].t_max).all(), name


def test_a_shadow_ray_goes_to_a_point_of_a_light_and_ends_before_it():
    scene, shadow = scene_of("cornell-box"), rays_of("cornell-box")["shadow"]
    light = scene.shapes[scene.lights[0].shape]
    corners = scene.vertices[scene.triangles[light.first : light.first + light.count]]
    low, high = corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)
    ends = shadow.origins.astype(np.float64) + shadow.directions.astype(np.float64)
    # Origin and direction are rounded to float32, of coordinates up to the scene's.
    slack = 2.0**-22 * np.abs(scene.vertices).max()
    assert (ends > low - slack).all() and (ends < high + slack).all()
    # All over the light, though some of it is behind some surfaces.
    wide = np.argmax(high - low)
    share = (ends[:, wide] - low[wide]) / (high[wide] - low[wide])
    assert np.histogram(share, 8, (0.0, 1.0))[0].min() > COUNT / 16
    met = brute_force(scene, shadow).primitive
    own = (met >= light.first) & (met < light.first + light.count)
    assert not own.any(), np.flatnonzero(own)[:5]


def test_shuffled_rays_are_those_of_the_first_bounce_in_another_order():
    rays = rays_of("cornell-box")

    def sorted_rows(one: Rays) -> NDArray[np.float32]:
        rows = np.concatenate([one.origins, one.directions], axis=1)
        return rows[np.lexsort(rows.T)]

    assert np.array_equal(sorted_rows(rays["shuffled"]), sorted_rows(rays["diffuse1"]))
    moved = (rays["shuffled"].directions != rays["diffuse1"].directions).any(axis=1)
    assert moved.mean() > 0.99


def test_random_rays_fill_the_box_and_all_directions():
    rays = rays_of("cornell-box")["random"]
    low, high = scene_box(scene_of("cornell-box"))
    share = (rays.origins - low) / (high - low)
    assert share.min() > -(2.0**-22) and share.max() < 1.0 + 2.0**-22
    bound = FOUR_SIGMA * (1.0 / 12.0 / COUNT) ** 0.5
    assert np.abs(share.mean(axis=0) - 0.5).max() < bound
    # A component of a uniform direction is uniform in [-1, 1], whose variance is 1/3.
    assert np.abs(rays.directions.mean(axis=0)).max() < FOUR_SIGMA * (1.0 / 3.0 / COUNT) ** 0.5


def test_bounces_inside_a_closed_body_all_hit_and_its_shadow_rays_see_the_sky():
    name = "analytic/furnace-diffuse"
    scene, rays = scene_of(name), rays_of(name, inside=True)
    for bounce in ("diffuse1", "diffuse2"):
        hits = brute_force(scene, rays[bounce])
        # A ray through an edge may escape, by rounding; there are none among so few.
        assert hits.hit.all(), (bounce, np.flatnonzero(~hits.hit)[:5])
    assert np.isinf(rays["shadow"].t_max).all()
    assert not brute_force(scene, rays["shadow"]).hit.any()


def test_rays_that_hit_nothing_are_an_error_that_names_them():
    with pytest.raises(RaysError, match="furnace-diffuse: no ray of the class diffuse1 hits"):
        rays_of("analytic/furnace-diffuse")
