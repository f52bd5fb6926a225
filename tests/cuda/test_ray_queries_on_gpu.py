"""Rays replayed on the GPU: the hits of the processor, bit for bit."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import haste_cuda
from harness.scene import Scene, load_scene
from harness.tracers.haste import to_core
from haste_cuda import _core

pytestmark = pytest.mark.gpu

ROOT = Path(__file__).parents[2]
SCENES = ("cornell-box", "hard", "mirror-glass", "skull", "three-spheres")
COUNT = 200_000
Rays = tuple[NDArray[np.float32], ...]


def random_rays(scene: Scene, seed: int) -> Rays:
    """Rays through a scene from everywhere, half of them with an interval of their own."""
    random = np.random.default_rng(seed)
    radii = scene.spheres[:, 3:]
    points = np.concatenate(
        [scene.vertices, scene.spheres[:, :3] - radii, scene.spheres[:, :3] + radii]
    ).astype(np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.linalg.norm(high - low)
    origins = random.uniform(low - 0.5 * size, high + 0.5 * size, (COUNT, 3))
    towards = random.uniform(low, high, (COUNT, 3)) - origins
    t_min = np.where(random.random(COUNT) < 0.5, 0.0, random.uniform(0, 1, COUNT))
    t_max = np.where(random.random(COUNT) < 0.5, np.inf, t_min + random.uniform(0, 1, COUNT))
    return tuple(array.astype(np.float32) for array in (origins, towards, t_min, t_max))


@pytest.fixture(scope="module", params=SCENES)
def case(request: pytest.FixtureRequest) -> tuple[str, Any, Rays]:
    """A scene's name, the scene on both sides, and rays."""
    scene = load_scene(ROOT / "scenes" / request.param)
    return request.param, to_core(scene, 2), random_rays(scene, 1)


def bits(t: NDArray[np.float32]) -> NDArray[np.uint32]:
    return t.view(np.uint32)


@pytest.mark.parametrize("any_hit", [False, True], ids=["closest", "any_hit"])
@pytest.mark.parametrize("traversal", _core.traversals())
def test_hits_on_gpu_and_cpu_are_equal_bit_for_bit(
    case: tuple[str, Any, Rays], any_hit: bool, traversal: str
):
    name, scene, rays = case
    if traversal == "brute_force":
        rays = tuple(array[:2000] for array in rays)
    gpu = haste_cuda.trace_cuda(scene, *rays, any_hit=any_hit, traversal=traversal)
    cpu = haste_cuda.trace_cpu(scene, *rays, any_hit=any_hit)
    hit = np.isfinite(cpu["t"])
    assert 0.05 < hit.mean() < 1.0, f"{name}: {hit.mean():.1%} of the rays hit"
    unequal = (bits(gpu["t"]) != bits(cpu["t"])) | (gpu["primitive"] != cpu["primitive"])
    first = int(np.argmax(unequal))
    assert not unequal.any(), (
        f"{name}: {unequal.sum()} of {len(unequal)} rays, the first {first}: "
        f"t {gpu['t'][first]!r} and {cpu['t'][first]!r}, "
        f"primitive {gpu['primitive'][first]} and {cpu['primitive'][first]}"
    )


def test_rays_moved_by_one_unit_in_the_last_place_give_other_bits(case: tuple[str, Any, Rays]):
    """Negative control of the comparison bit for bit."""
    _, scene, (origins, towards, t_min, t_max) = case
    moved = np.nextafter(origins, np.float32(np.inf))
    gpu = haste_cuda.trace_cuda(scene, origins, towards, t_min, t_max)
    cpu = haste_cuda.trace_cpu(scene, moved, towards, t_min, t_max)
    assert (bits(gpu["t"]) != bits(cpu["t"])).any()


@pytest.mark.parametrize("traversal", ["bvh2", "bvh8"])
def test_hits_depend_on_neither_block_size_nor_run(case: tuple[str, Any, Rays], traversal: str):
    name, scene, rays = case
    runs = [
        haste_cuda.trace_cuda(scene, *rays, block=block, traversal=traversal)
        for block in (64, 128, 256, 128)
    ]
    for other in runs[1:]:
        assert np.array_equal(bits(runs[0]["t"]), bits(other["t"])), name
        assert np.array_equal(runs[0]["primitive"], other["primitive"]), name


def test_copies_and_compilation_are_told_apart_from_tracing(case: tuple[str, Any, Rays]):
    name, scene, rays = case
    haste_cuda.trace_cuda(scene, *rays)
    warm = haste_cuda.trace_cuda(scene, *rays)
    assert min(warm["seconds"]) > 0.0 and warm["scene_upload_seconds"] == 0.0, (name, warm)
    assert warm["upload_seconds"] > 0.0 and warm["download_seconds"] > 0.0, (name, warm)


def test_rays_that_are_held_are_copied_once_and_have_the_same_hits(case: tuple[str, Any, Rays]):
    name, scene, rays = case
    held = haste_cuda.Rays(*rays)
    expected = haste_cuda.trace_cuda(scene, *rays)
    first, second = (haste_cuda.trace_cuda(scene, held) for _ in range(2))
    assert first["upload_seconds"] > 0.0 and second["upload_seconds"] == 0.0, (name, second)
    for traversal in ("bvh2", "bvh8"):
        found = haste_cuda.trace_cuda(scene, held, traversal=traversal)
        for answer in (first, second, found):
            assert np.array_equal(bits(answer["t"]), bits(expected["t"])), (name, traversal)
            assert np.array_equal(answer["primitive"], expected["primitive"]), (name, traversal)


def test_rays_are_held_for_any_scene(case: tuple[str, Any, Rays]):
    name, scene, rays = case
    other = to_core(load_scene(ROOT / "scenes" / "cornell-box"), 2)
    held = haste_cuda.Rays(*rays)
    for one in (other, scene, other):
        found, expected = (haste_cuda.trace_cuda(one, *which) for which in ((held,), rays))
        assert np.array_equal(bits(found["t"]), bits(expected["t"])), name


def used_megabytes() -> int:
    """Memory of the first GPU that is in use, [MiB]."""
    if shutil.which("nvidia-smi") is None:
        pytest.skip("nvidia-smi is missing")
    command = ["nvidia-smi", "--id=0", "--query-gpu=memory.used", "--format=csv,noheader,nounits"]
    return int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def test_the_memory_of_rays_that_are_dropped_is_free_again():
    scene = to_core(load_scene(ROOT / "scenes" / "cornell-box"), 2)
    # Batches of 128 MiB, which a driver does not keep for later.
    count = 1 << 22
    towards = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (count, 1))
    ends = np.zeros(count, np.float32), np.full(count, np.inf, np.float32)
    haste_cuda.trace_cuda(scene, towards[:1], towards[:1], ends[0][:1], ends[1][:1])
    before = used_megabytes()
    held = [haste_cuda.Rays(towards, towards, *ends) for _ in range(4)]
    for rays in held:
        haste_cuda.trace_cuda(scene, rays, hits=False)
    between = used_megabytes()
    assert between - before >= 4 * 128, (before, between)
    # The last of them is named by the loop too.
    del held, rays
    after = used_megabytes()
    assert after - before < 128, (before, between, after)


def test_without_hits_there_are_times_alone(case: tuple[str, Any, Rays]):
    name, scene, rays = case
    answer = haste_cuda.trace_cuda(scene, *rays, hits=False, repeats=2)
    assert not {"t", "primitive"} & answer.keys(), (name, answer.keys())
    assert min(answer["seconds"]) > 0.0 and answer["download_seconds"] == 0.0, (name, answer)


def test_no_ray_is_no_hit(case: tuple[str, Any, Rays]):
    _, scene, rays = case
    answer = haste_cuda.trace_cuda(scene, *(array[:0] for array in rays))
    assert answer["t"].shape == (0,) and answer["primitive"].shape == (0,)


def test_what_is_visited_is_the_same_on_gpu_and_cpu(case: tuple[str, Any, Rays]):
    name, scene, rays = case
    # From the origin on: what lies before t_min is skipped by the processor's bvh8 alone.
    origin, direction, t_min, t_max = (array[:2000] for array in rays)
    rays = (origin, direction, np.zeros_like(t_min), t_max)
    for traversal in _core.traversals():
        sides = [
            trace(scene, *rays, traversal=traversal, count=True)
            for trace in (haste_cuda.trace_cuda, haste_cuda.trace_cpu)
        ]
        # Both add the same planes of bvh8 up in another order. A ray that starts on a wall is
        # inside of its box or not by the last bits: of the first nodes, one or none.
        room = 0.05 if traversal == "bvh8" else 1e-3
        for quantity in ("nodes", "triangles"):
            a, b = (side[quantity] for side in sides)
            assert abs(a - b) <= room * b, (name, traversal, quantity, a, b)


def test_every_repeat_has_a_time_of_its_own(case: tuple[str, Any, Rays]):
    _, scene, rays = case
    assert len(haste_cuda.trace_cuda(scene, *rays, repeats=3, traversal="bvh8")["seconds"]) == 3


def test_a_block_that_makes_no_sense_is_refused(case: tuple[str, Any, Rays]):
    _, scene, rays = case
    with pytest.raises(ValueError, match="block must be a multiple of 32 from 32 to 1024, not 33"):
        haste_cuda.trace_cuda(scene, *rays, block=33)
