"""Samples that are no numbers are left out, counted and named; sums that leave their range are not
published."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from haste_cuda._core import testing

import haste_cuda
from harness.gate import _failure
from harness.scene import load_scene, load_settings
from harness.tables.read import ImageSet
from harness.tracers.haste import HasteCpu, to_core, to_core_settings

SCENES = Path(__file__).parents[2] / "scenes"
SIZE, SAMPLES = 24, 4
STANDARD = sorted(path.parent for path in SCENES.glob("*/scene.xml"))
LARGE = ("bumpy-262k", "bumpy-4m", "menger-4")


def test_light_that_is_no_number_is_left_out_and_counted() -> None:
    core = to_core(load_scene(SCENES / "cornell-box", width=SIZE, height=SIZE), 2)
    settings = to_core_settings(load_settings(SCENES / "cornell-box").render("haste", SIZE, SIZE))
    done = {
        reading: testing.render_planted(
            core, settings, seed=1, samples=SAMPLES, reading=reading, threads=2
        )
        for reading in ("none", "a_light_is_no_number")
    }
    assert done["none"]["non_finite"] == 0
    assert done["a_light_is_no_number"]["non_finite"] > 0
    assert np.isfinite(done["a_light_is_no_number"]["film"]).all()


def test_an_image_that_lacks_samples_fails_with_their_number() -> None:
    image = np.ones((2, 4, 4, 3), np.float32)
    records = ({"non_finite": 0.0}, {"non_finite": 3.0})
    assert _failure(ImageSet(image, (0, 1), 4, records, ())) == (
        "3 samples are not finite and left out"
    )
    assert _failure(ImageSet(image, (0, 1), 4, records[:1], ())) == ""


@pytest.mark.parametrize("folder", STANDARD, ids=lambda path: path.name)
def test_no_published_scene_has_a_sample_that_is_no_number(folder: Path) -> None:
    if folder.name in LARGE:
        pytest.skip("too large to build for a few samples; smaller ones of its kind are not")
    settings = load_settings(folder)
    scene = load_scene(folder, width=SIZE, height=SIZE, recentre=settings.recentre)
    core = to_core(scene, 2)
    for model in settings.models:
        how = to_core_settings(settings.render(model, SIZE, SIZE))
        done = haste_cuda.render_cpu(core, model, how, seed=2, samples=SAMPLES)
        assert done["non_finite"] == 0, f"{folder.name} {model}: {done['non_finite']} samples"


def test_an_overflow_names_the_pixel_and_the_scene() -> None:
    """Mirrors that shine, reflecting more than they get: the sum doubles with every bounce."""
    folder = SCENES / "analytic" / "mirror-box"
    settings = load_settings(folder).render("path", 4, 4)
    tracer = HasteCpu(threads=1)
    tracer.load(folder, replace(settings, max_depth=60, rr_depth=1000))
    scene = tracer.imported
    doubling = [replace(material, reflection=2.0) for material in scene.materials]
    tracer.scene = to_core(replace(scene, materials=doubling), 1)
    with pytest.raises(haste_cuda.FilmOverflow, match=r"mirror-box: .* pixel \(\d, \d\)"):
        tracer.render(0, 4096)
