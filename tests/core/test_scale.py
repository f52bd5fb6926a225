"""Films of scenes that a power of two has scaled are equal bit for bit: nothing has a size of its
own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import haste_cuda
from harness.scene import RenderSettings, Scene, load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

SCENES = Path(__file__).parents[2] / "scenes"
NAMES = (
    *("cornell-box", "mirror-glass", "skull", "three-spheres"),
    *("analytic/glass-slab", "analytic/furnace-phong", "analytic/disk-light", "analytic/wall-sky"),
)
SIZE, SAMPLES = 24, 4


def sized(scene: Scene, factor: float) -> Scene:
    """The scene and its camera, so many times as large; exact for powers of two."""
    camera = scene.camera
    x, y, z = (factor * value for value in camera.origin)
    return replace(
        scene,
        vertices=scene.vertices * np.float32(factor),
        spheres=scene.spheres * np.float32(factor),
        camera=replace(camera, origin=(x, y, z), near=factor * camera.near),
    )


def film_of(scene: Scene, render: RenderSettings) -> str:
    settings = to_core_settings(render)
    done = haste_cuda.render_cpu(to_core(scene, 2), render.model, settings, seed=3, samples=SAMPLES)
    assert done["non_finite"] == 0
    return str(done["film_sha256"])


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_scaled_by_a_power_of_two_has_the_same_film(name: str) -> None:
    settings = load_settings(SCENES / name)
    scene = load_scene(SCENES / name, width=SIZE, height=SIZE, recentre=settings.recentre)
    for model in settings.models:
        render = settings.render(model, SIZE, SIZE)
        own = film_of(scene, render)
        for factor in (2.0**-20, 2.0**20):
            assert film_of(sized(scene, factor), render) == own, f"{model}, times {factor:g}"


def test_a_camera_that_is_not_scaled_with_its_scene_sees_something_else() -> None:
    """Negative control."""
    settings = load_settings(SCENES / "cornell-box")
    scene = load_scene(SCENES / "cornell-box", width=SIZE, height=SIZE)
    render = settings.render("path", SIZE, SIZE)
    other = replace(sized(scene, 2.0), camera=scene.camera)
    assert film_of(other, render) != film_of(scene, render)
