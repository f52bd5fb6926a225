"""Renders on the GPU: equal bits however they are launched, and the CPU's image."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haste_cuda
from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

pytestmark = pytest.mark.gpu

SCENES = sorted(path.parent for path in Path(__file__).parents[2].glob("scenes/*/scene.xml"))
MODELS = ("haste", "whitted", "path")
SIZE = 32
SAMPLES = 16


@pytest.fixture(scope="module", params=SCENES, ids=lambda path: path.name)
def scene(request: pytest.FixtureRequest) -> tuple[Path, Any]:
    """A scene's folder and the scene itself."""
    return request.param, to_core(load_scene(request.param, width=SIZE, height=SIZE), 2)


def render(
    scene: tuple[Path, Any],
    model: str,
    side: str = "cuda",
    clamp: float = np.inf,
    **schedule: Any,
) -> Any:
    """Render with fixed seed and samples, on either side."""
    folder, core = scene
    settings = to_core_settings(load_settings(folder).render(model, SIZE, SIZE), clamp)
    function = haste_cuda.render_cuda if side == "cuda" else haste_cuda.render_cpu
    return function(core, model, settings, **{"seed": 7, "samples": SAMPLES, **schedule})


@pytest.mark.parametrize("model", MODELS)
def test_film_bits_depend_on_neither_block_size_nor_run(scene: tuple[Path, Any], model: str):
    blocks = (64, 128, 256, 128, 128)
    films = [render(scene, model, block=block)["film_sha256"] for block in blocks]
    assert len(set(films)) == 1, f"{scene[0].name} {model}: {dict(zip(blocks, films, strict=True))}"


@pytest.mark.parametrize("model", MODELS)
def test_another_seed_gives_other_bits(scene: tuple[Path, Any], model: str):
    """Negative control of the claim of equal bits."""
    if model not in load_settings(scene[0]).models:
        pytest.skip("not a model of the scene: all that it sees there may be the same sky")
    assert render(scene, model)["film_sha256"] != render(scene, model, seed=8)["film_sha256"]


def share_of_unequal_pixels(a: np.ndarray, b: np.ndarray) -> float:
    """Share of pixels that differ by more than 1e-4 of the image's mean."""
    return float(np.mean(np.abs(a - b).max(axis=-1) > 1e-4 * b.mean()))


@pytest.mark.parametrize("model", MODELS)
def test_gpu_and_cpu_follow_the_same_paths(scene: tuple[Path, Any], model: str):
    """Both draw the same random numbers. Films of two seeds share no pixels but black ones."""
    gpu = render(scene, model, count_rays=True)
    cpu = render(scene, model, "cpu", count_rays=True)
    unequal = share_of_unequal_pixels(gpu["film"], cpu["film"])
    assert unequal <= 0.01, f"{scene[0].name} {model}: {unequal:.2%} of the pixels differ"
    for rays in ("camera", "shadow", "ambient", "bounce"):
        assert gpu[rays] == pytest.approx(cpu[rays], rel=1e-3), f"{scene[0].name} {model} {rays}"


ANALYTIC = sorted(
    path.parent for path in Path(__file__).parents[2].glob("scenes/analytic/*/scene.xml")
)


@pytest.mark.parametrize(
    "folder",
    [*ANALYTIC, *(path for path in SCENES if path.name == "skull")],
    ids=lambda path: path.name,
)
def test_films_of_gpu_and_cpu_are_equal_bit_for_bit(folder: Path):
    """Sums, products, quotients, roots and fma round alike on both sides, and there is no more."""
    own = (folder, to_core(load_scene(folder, width=SIZE, height=SIZE), 2))
    for model in load_settings(folder).models:
        gpu, cpu = render(own, model), render(own, model, "cpu")
        differ = (gpu["film"] != cpu["film"]).any(axis=-1)
        assert gpu["film_sha256"] == cpu["film_sha256"], f"{model}: {differ.sum()} pixels differ"


def test_fast_arithmetic_is_not_equal_and_nearly_right():
    """Negative control of equal bits, and what the fast precision promises: nearly the same."""
    folder = next(path for path in SCENES if path.name == "mirror-glass")
    scene = (folder, to_core(load_scene(folder, width=SIZE, height=SIZE), 2))
    fast, cpu = render(scene, "path", precision="fast"), render(scene, "path", "cpu")
    assert fast["film_sha256"] != cpu["film_sha256"]
    assert share_of_unequal_pixels(fast["film"], cpu["film"]) < 0.1


def test_a_clamp_is_that_of_the_cpu_and_costs_no_bit_where_no_light_reaches_it(
    scene: tuple[Path, Any],
):
    gpu, cpu = (render(scene, "path", side, clamp=0.05)["film"] for side in ("cuda", "cpu"))
    unequal = share_of_unequal_pixels(gpu, cpu)
    assert unequal <= 0.01, f"{scene[0].name}: {unequal:.2%} of the pixels differ"
    films = {render(scene, "path", clamp=limit)["film_sha256"] for limit in (1e9, np.inf)}
    assert len(films) == 1, "a kernel with the clamp adds up what one without it does"


def test_another_seed_is_another_path():
    """Negative control of the comparison with the CPU."""
    folder = next(path for path in SCENES if path.name == "cornell-box")
    box = (folder, to_core(load_scene(folder, width=SIZE, height=SIZE), 2))
    gpu, cpu = render(box, "path"), render(box, "path", "cpu", seed=8)
    assert share_of_unequal_pixels(gpu["film"], cpu["film"]) > 0.5


def test_counting_rays_changes_no_bit(scene: tuple[Path, Any]):
    counted = render(scene, "path", count_rays=True)
    assert counted["film_sha256"] == render(scene, "path")["film_sha256"]
    assert counted["camera"] == SIZE * SIZE * SAMPLES


def test_a_refused_launch_names_the_kernel_and_leaves_the_device_usable(scene: tuple[Path, Any]):
    before = render(scene, "path")
    if 1024 * before["registers"] <= 65536:
        pytest.skip(f"a block of 1024 threads fits: {before['registers']} registers a thread")
    with pytest.raises(haste_cuda.CudaError, match="depth_first path watertight"):
        render(scene, "path", block=1024)
    assert render(scene, "path")["film_sha256"] == before["film_sha256"]
