"""The gates' negative controls: a right image passes, every planted error fails.

The scene `hard` is the one that shows the wrong readings of the paper; each is rendered by the same
core with that reading planted, and judged against Mitsuba as a run of the workflow would be.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from haste_cuda._core import testing
from numpy.typing import NDArray

import haste_cuda
from harness.bounds import GateSettings
from harness.scene import load_scene, load_settings
from harness.statistics.bias import GATE_LEVEL, Verdict, judge_equivalence, relative_bias
from harness.statistics.metrics import Truth, make_truth
from harness.statistics.tiles import compare_tiles, rounding_bound, sidak_level
from harness.tracers.haste import to_core, to_core_settings
from reference.mitsuba import available, render_truth

SCENE = Path(__file__).parents[2] / "scenes" / "hard"
SIZE = 64
SEEDS = 16
BATCHES = 16
SPP = 16
TRUTH_SPP = 64
IMAGES_OF_A_RUN = 5 * 3 * 3
"""Scenes, models and tracers of the default run: the family of its tile tests."""

READINGS = [
    "ambient_is_cosine_weighted",
    "lights_are_sampled_on_the_surface",
    "refraction_uses_the_unturned_normal",
    "glass_lets_shadow_rays_through",
    "lights_block_themselves",
]

Images = NDArray[np.float64]


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> Truth:
    """Mitsuba's image of the scene in the model `haste`, in independent batches."""
    reason = available("llvm_ad_rgb")
    assert reason is None, reason
    folder = tmp_path_factory.mktemp("truth")
    settings = load_settings(SCENE).render("haste", SIZE, SIZE)
    render_truth(SCENE, settings, batches=BATCHES, spp=TRUTH_SPP, out_dir=folder)
    return make_truth(np.stack([np.load(path) for path in sorted(folder.glob("batch_*.npy"))]))


@pytest.fixture(scope="module")
def core() -> haste_cuda.Scene:
    """The scene in the extension's form."""
    return to_core(load_scene(SCENE, width=SIZE, height=SIZE), 2)


def render(core: haste_cuda.Scene, reading: str) -> Images:
    """One image a seed, shape [SEEDS, SIZE, SIZE, 3], with a reading planted."""
    settings = to_core_settings(load_settings(SCENE).render("haste", SIZE, SIZE))
    return np.stack(
        [
            testing.render_planted(core, settings, seed=seed, samples=SPP, reading=reading)["film"]
            for seed in range(SEEDS)
        ]
    )


@pytest.fixture(scope="module")
def right(core: haste_cuda.Scene) -> Images:
    """The images of the paper's own reading."""
    return render(core, "none")


def verdicts(images: Images, truth: Truth) -> tuple[Verdict, int, str]:
    """The verdict on the mean, the number of rejected tiles, and both in words."""
    settings = GateSettings()
    bias = judge_equivalence(relative_bias(images, truth, GATE_LEVEL), settings.delta, BATCHES)
    tiles = compare_tiles(images, truth.batches, rounding_bound(SPP), settings.tile)
    level = sidak_level(IMAGES_OF_A_RUN * tiles.p.size, settings.alpha)
    rejected = int((tiles.p < level).sum())
    words = (
        f"bias {bias.bias}: {bias.verdict.value}; smallest p {tiles.smallest}, level {level:.1e}"
    )
    return bias.verdict, rejected, words


def test_the_paper_s_own_reading_passes_both_gates(right: Images, truth: Truth) -> None:
    verdict, rejected, words = verdicts(right, truth)
    assert verdict is Verdict.PASS and rejected == 0, words


def test_the_planted_core_renders_the_film_of_the_model_itself(core: haste_cuda.Scene) -> None:
    settings = to_core_settings(load_settings(SCENE).render("haste", SIZE, SIZE))
    planted = testing.render_planted(core, settings, seed=1, samples=2, reading="none")
    itself = haste_cuda.render_cpu(core, "haste", settings, seed=1, samples=2)
    assert planted["film_sha256"] == itself["film_sha256"]


@pytest.mark.parametrize("reading", READINGS)
def test_a_wrong_reading_of_the_paper_fails(
    reading: str, core: haste_cuda.Scene, truth: Truth
) -> None:
    verdict, rejected, words = verdicts(render(core, reading), truth)
    assert verdict is Verdict.FAIL or rejected > 0, f"{reading} passes: {words}"


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_a_mean_that_is_one_per_cent_off_fails(factor: float, right: Images, truth: Truth) -> None:
    verdict, _, words = verdicts(right * factor, truth)
    assert verdict is Verdict.FAIL, f"times {factor}: {words}"


def test_one_tile_that_is_ten_per_cent_off_is_rejected(right: Images, truth: Truth) -> None:
    # A tile of the lit floor, where the image is neither dark nor a light.
    images = right.copy()
    images[:, 48:56, 32:40] *= 1.1
    _, rejected, words = verdicts(images, truth)
    assert rejected >= 1, words


def test_an_unknown_reading_is_refused_by_name(core: haste_cuda.Scene) -> None:
    with pytest.raises(ValueError, match="no reading is called x"):
        testing.render_planted(core, haste_cuda.Settings(), seed=1, samples=1, reading="x")
