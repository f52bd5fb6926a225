"""What must not change an image, or must change it in a known way: no truth is needed to tell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import haste_cuda
from harness.scene import Light, RenderSettings, Scene, load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

SCENES = Path(__file__).parents[2] / "scenes"
SIZE, SAMPLES = 32, 8
NAMES = ("cornell-box", "mirror-glass", "skull")
Film = NDArray[np.float64]


def loaded(name: str, model: str = "path") -> tuple[Scene, RenderSettings]:
    settings = load_settings(SCENES / name)
    scene = load_scene(SCENES / name, width=SIZE, height=SIZE, recentre=settings.recentre)
    return scene, settings.render(model, SIZE, SIZE)


def film_of(scene: Scene, render: RenderSettings, seed: int = 3, samples: int = SAMPLES) -> Film:
    done = haste_cuda.render_cpu(
        to_core(scene, 2), render.model, to_core_settings(render), seed=seed, samples=samples
    )
    return np.asarray(done["film"])


def dark_meshes(scene: Scene) -> list[int]:
    """Places in `Scene.shapes` of meshes of two triangles and more that are no lights."""
    return [
        place
        for place, shape in enumerate(scene.shapes)
        if shape.kind == "mesh" and shape.light < 0 and shape.count > 1
    ]


@pytest.mark.parametrize("name", NAMES)
def test_the_order_of_triangles_changes_no_bit(name: str) -> None:
    """Not of lights, whose triangles are drawn by their numbers."""
    scene, render = loaded(name)
    order = np.arange(len(scene.triangles))
    random = np.random.default_rng(1)
    for place in dark_meshes(scene):
        shape = scene.shapes[place]
        part = slice(shape.first, shape.first + shape.count)
        order[part] = random.permutation(order[part])
    assert (order != np.arange(len(order))).any()
    shuffled = replace(scene, triangles=scene.triangles[order])
    assert np.array_equal(film_of(scene, render), film_of(shuffled, render))


@pytest.mark.parametrize("name", NAMES)
def test_a_mesh_in_two_shapes_gives_the_same_bits(name: str) -> None:
    scene, render = loaded(name)
    place = dark_meshes(scene)[0]
    shape = scene.shapes[place]
    half = shape.count // 2
    shapes = list(scene.shapes)
    shapes[place] = replace(shape, count=half)
    shapes.append(replace(shape, first=shape.first + half, count=shape.count - half))
    owner = scene.triangle_shape.copy()
    owner[shape.first + half : shape.first + shape.count] = len(shapes) - 1
    split = replace(scene, shapes=shapes, triangle_shape=owner)
    assert np.array_equal(film_of(scene, render), film_of(split, render))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("model", ["path", "haste"])
def test_lights_twice_as_bright_give_an_image_twice_as_bright_bit_for_bit(
    name: str, model: str
) -> None:
    scene, render = loaded(name, model)
    lights = [
        replace(light, radiance=tuple(2.0 * value for value in light.radiance))
        for light in scene.lights
    ]
    sky = scene.environment
    sky = None if sky is None else tuple(2.0 * value for value in sky)
    brighter = replace(scene, lights=lights, environment=sky)
    assert np.array_equal(2.0 * film_of(scene, render), film_of(brighter, render))


def means(scene: Scene, render: RenderSettings, seeds: range) -> list[float]:
    return [float(film_of(scene, render, seed).mean()) for seed in seeds]


def assert_same_mean(one: list[float], other: list[float], what: str) -> None:
    """Welch's test at a level of 1e-4, and enough seeds to see one per cent."""
    test = stats.ttest_ind(one, other, equal_var=False)
    error = np.hypot(stats.sem(one), stats.sem(other)) / np.mean(one)
    assert error < 0.01, f"{what}: a standard error of {error:.2%} sees nothing"
    assert test.pvalue > 1e-4, f"{what}: {np.mean(one)} and {np.mean(other)}, p = {test.pvalue:.2g}"


def split_light(scene: Scene) -> Scene:
    """The scene with its first mesh light cut in two lights."""
    number, light = next(
        (number, light)
        for number, light in enumerate(scene.lights)
        if scene.shapes[light.shape].kind == "mesh" and scene.shapes[light.shape].count > 1
    )
    shape = scene.shapes[light.shape]
    half = shape.count // 2
    shapes, lights = list(scene.shapes), list(scene.lights)
    shapes[light.shape] = replace(shape, count=half)
    new = len(lights)
    shapes.append(replace(shape, first=shape.first + half, count=shape.count - half, light=new))
    lights.append(replace(lights[number], shape=len(shapes) - 1))
    owner = scene.triangle_shape.copy()
    owner[shape.first + half : shape.first + shape.count] = len(shapes) - 1
    return replace(scene, shapes=shapes, lights=lights, triangle_shape=owner)


def test_a_light_cut_in_two_shines_as_before() -> None:
    scene, render = loaded("cornell-box")
    whole = means(scene, render, range(24))
    assert_same_mean(whole, means(split_light(scene), render, range(100, 124)), "light in two")


def dimmed(light: Light) -> Light:
    return replace(light, radiance=tuple(0.9 * value for value in light.radiance))


def test_a_light_that_loses_a_tenth_when_it_is_cut_is_found() -> None:
    """Negative control."""
    scene, render = loaded("cornell-box")
    cut = split_light(scene)
    wrong = replace(cut, lights=[dimmed(light) for light in cut.lights])
    with pytest.raises(AssertionError, match="light in two"):
        assert_same_mean(
            means(scene, render, range(24)), means(wrong, render, range(100, 124)), "light in two"
        )


def mirrored(scene: Scene) -> Scene:
    """The scene and its camera as in a mirror, x being turned round; windings are turned back."""
    turn = np.array([-1.0, 1.0, 1.0], np.float32)
    camera = scene.camera

    def other(point: tuple[float, float, float]) -> tuple[float, float, float]:
        return (-point[0], point[1], point[2])

    return replace(
        scene,
        vertices=scene.vertices * turn,
        normals=scene.normals * turn,
        triangles=np.ascontiguousarray(scene.triangles[:, [0, 2, 1]]),
        spheres=scene.spheres * np.array([-1.0, 1.0, 1.0, 1.0], np.float32),
        camera=replace(
            camera,
            origin=other(camera.origin),
            corner=other(camera.corner),
            dx=other(camera.dx),
            dy=other(camera.dy),
        ),
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_in_a_mirror_has_the_image_of_the_scene(name: str) -> None:
    """Pixel by pixel, as its camera is in the mirror too; drawn by chance, so not bit for bit."""
    scene, render = loaded(name)
    one, other = (film_of(one, render, samples=256) for one in (scene, mirrored(scene)))
    blocks = [film.reshape(8, 4, 8, 4, 3).mean(axis=(1, 3, 4)) for film in (one, other)]
    again = film_of(scene, render, seed=4, samples=256).reshape(8, 4, 8, 4, 3).mean(axis=(1, 3, 4))
    off, noise = np.abs(blocks[1] - blocks[0]), np.abs(again - blocks[0])
    assert off.mean() <= 2.0 * noise.mean(), f"{name}: {off.mean():.3g}, noise {noise.mean():.3g}"
