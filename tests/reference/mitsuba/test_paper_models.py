"""The integrators `haste` and `whitted` against a second, plain reading of the same models."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats
from spheres_and_planes import BLACK, Array, Body, Material, Model, Reading

from reference.mitsuba import load, render

SIZE = 16
TILE = 4
BATCHES = 8
LAYERS = 3
FLOOR = Material(
    diffuse=(0.6, 0.5, 0.3), specular=(0.2, 0.3, 0.4), ambient=(0.5, 0.6, 0.4), exponent=12.0
)
# Seen from below, where it is the denser side: total internal reflection.
CEILING = Material(
    diffuse=(0.4, 0.4, 0.5), ambient=(0.4, 0.4, 0.4), reflection=0.1, transmission=0.8, ior=1.4
)
SHINY = Material(
    diffuse=(0.3, 0.2, 0.1),
    specular=(0.5, 0.5, 0.5),
    ambient=(0.3, 0.3, 0.3),
    exponent=40.0,
    reflection=0.4,
)
TINTED = Material(
    diffuse=(0.1, 0.2, 0.1), ambient=(0.2, 0.2, 0.2), reflection=0.2, transmission=0.6, ior=1.4
)
GLASS = Material(dielectric=True, ior=1.5)

BODIES = [
    Body("square", (0.0, 0.0, 0.0), 3.0, FLOOR),
    Body("square", (0.3, 0.2, 3.0), 2.0, CEILING),
    Body("sphere", (-0.9, 0.7, 0.6), 0.55, SHINY),
    Body("sphere", (0.7, 0.8, 0.7), 0.5, TINTED),
    Body("sphere", (0.0, -0.9, 0.55), 0.5, GLASS),
    # A big sphere light, half sunk in the floor; one inside the glass; a square between.
    Body("sphere", (1.3, -0.8, 0.1), 0.5, Material(), (1.5, 1.2, 1.0)),
    Body("sphere", (0.05, -0.9, 0.6), 0.15, Material(), (2.0, 2.5, 3.0)),
    Body("square", (-0.8, -0.4, 2.4), 0.5, Material(reflection=0.1), (1.0, 1.5, 2.0)),
]
EYE, TARGET = (0.4, -4.2, 1.6), (0.1, 0.0, 1.55)


DOWNWARDS = (0.1, 0.0, 0.3)


def scene_description(
    bodies: list[Body], fov: float = 60.0, target: tuple[float, float, float] = TARGET
) -> dict[str, Any]:
    import mitsuba as mi

    place = mi.ScalarTransform4f().look_at(origin=list(EYE), target=list(target), up=[0, 0, 1])
    return {
        "type": "scene",
        "sensor": {"type": "perspective", "fov": fov, "to_world": place},
        **{f"body_{k}": body.mitsuba() for k, body in enumerate(bodies)},
    }


def camera_rays(loaded: Any, per_pixel: int, seed: int) -> tuple[Array, Array]:
    """Rays of every pixel, [h * w * per_pixel, 3], uniform in the pixel."""
    import mitsuba as mi

    generator = np.random.default_rng(seed)
    y, x = np.divmod(np.repeat(np.arange(SIZE * SIZE), per_pixel), SIZE)
    position = (np.stack([x, y]) + generator.random((2, len(x)))) / SIZE
    sensor = loaded.scene.sensors()[0]
    ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(position.astype(np.float32)), mi.Point2f(0.5))
    o, d = np.asarray(ray.o, dtype=np.float64).T, np.asarray(ray.d, dtype=np.float64).T
    return o, d / np.linalg.norm(d, axis=1, keepdims=True)


def plain_batches(model: Model, loaded: Any, per_pixel: int) -> Array:
    batches = []
    for k in range(BATCHES):
        o, d = camera_rays(loaded, per_pixel, seed=500 + k)
        batches.append(model.radiance(o, d).reshape(SIZE, SIZE, per_pixel, 3).mean(axis=2))
    return np.stack(batches)


def tile_means(images: Array) -> Array:
    tiles = SIZE // TILE
    shape = (len(images), tiles, TILE, tiles, TILE, 3)
    return images.reshape(shape).mean(axis=(2, 4, 5)).reshape(len(images), -1)


def rejected_tiles(ours: Array, plain: Array, level: float = 1e-3) -> int:
    """Tiles whose means differ (Welch), at a family-wise level (Sidak)."""
    a, b = tile_means(ours), tile_means(plain)
    spread = a.var(axis=0) + b.var(axis=0)
    a, b = a[:, spread > 0.0], b[:, spread > 0.0]
    p = stats.ttest_ind(a, b, equal_var=False).pvalue
    return int(np.sum(p < 1.0 - (1.0 - level) ** (1.0 / len(p))))


def relative_difference(ours: Array, plain: Array) -> tuple[float, float]:
    """Of the image means, with its standard error."""
    a, b = ours.mean(axis=(1, 2, 3)), plain.mean(axis=(1, 2, 3))
    error = np.sqrt(a.var(ddof=1) / len(a) + b.var(ddof=1) / len(b))
    return float(a.mean() / b.mean() - 1.0), float(error / b.mean())


@pytest.fixture(scope="module")
def haste_images(variant: str, settings: Any) -> tuple[Any, Array]:
    import mitsuba as mi

    mi.set_variant(variant)
    chosen = settings("haste", SIZE, max_layers=LAYERS, light_samples=2, ambient_samples=3)
    loaded = load(scene_description(BODIES), chosen, variant)
    return loaded, np.stack([render(loaded, seed, 96)[0] for seed in range(BATCHES)])


def test_haste_agrees_with_the_plain_reading(haste_images: tuple[Any, Array]):
    loaded, ours = haste_images
    plain = plain_batches(Model(BODIES, layers=LAYERS, seed=1), loaded, 20)
    difference, error = relative_difference(ours, plain)
    assert abs(difference) + 2.0 * error < 0.015, f"{difference:+.4%} +- {error:.4%}"
    assert abs(difference) < 4.0 * error, f"{difference:+.4%} +- {error:.4%}"
    assert rejected_tiles(ours, plain) == 0


@pytest.mark.parametrize(
    "mistake",
    [
        "ambient_is_cosine_weighted",
        "lights_are_sampled_on_the_surface",
        "light_passes_through_glass",
        "total_reflection_feeds_the_mirror",
        "ambient_sees_emission",
        "fronts_only",
    ],
)
def test_haste_disagrees_with_each_wrong_reading(haste_images: tuple[Any, Array], mistake: str):
    loaded, ours = haste_images
    model = Model(BODIES, layers=LAYERS, seed=2, reading=Reading(**{mistake: True}))
    plain = plain_batches(model, loaded, 20)
    difference, error = relative_difference(ours, plain)
    seen = rejected_tiles(ours, plain) > 0 or abs(difference) > 5.0 * error
    assert seen, f"{mistake}: {difference:+.4%} +- {error:.4%}"


def test_whitted_agrees_with_the_plain_reading(active: str, settings: Any):
    ambient = (0.1, 0.2, 0.05)
    chosen = settings("whitted", SIZE, max_layers=LAYERS, ambient=ambient)
    loaded = load(scene_description(BODIES), chosen, active)
    ours = np.stack([render(loaded, seed, 64)[0] for seed in range(BATCHES)])
    plain = plain_batches(Model(BODIES, LAYERS, seed=3, ambient=ambient), loaded, 20)
    difference, error = relative_difference(ours, plain)
    assert abs(difference) < 4.0 * error < 0.02, f"{difference:+.4%} +- {error:.4%}"
    assert rejected_tiles(ours, plain) == 0


def test_more_light_and_ambient_samples_change_noise_alone(active: str, settings: Any):
    images = []
    for samples in (1, 5):
        chosen = settings(
            "haste", SIZE, max_layers=2, light_samples=samples, ambient_samples=samples
        )
        loaded = load(scene_description(BODIES), chosen, active)
        images.append(np.stack([render(loaded, seed, 32)[0] for seed in range(BATCHES)]))
    one, five = images
    difference, error = relative_difference(one, five)
    assert abs(difference) < 4.0 * error, f"{difference:+.4%} +- {error:.4%}"
    assert rejected_tiles(one, five) == 0
    assert five.var(axis=0).mean() < one.var(axis=0).mean()


@pytest.mark.parametrize("seed", [0, 41])
def test_whitted_on_one_floor_is_its_formula(active: str, settings: Any, seed: int):
    light = (0.6, 1.1, 1.9)
    radiance = np.array((2.0, 1.0, 0.5))
    bodies = [
        Body("square", (0.0, 0.0, 0.0), 50.0, FLOOR),
        Body("sphere", light, 0.4, Material(), tuple(radiance)),
    ]
    scene = scene_description(bodies, fov=0.01, target=DOWNWARDS)
    image, _ = render(load(scene, settings("whitted", 1), active), seed, 4)
    eye, target = np.array(EYE), np.array(DOWNWARDS)
    p = eye + (target - eye) * (eye[2] / (eye[2] - target[2]))
    V = (eye - p) / np.linalg.norm(eye - p)
    L = (light - p) / np.linalg.norm(light - p)
    R = np.array((-L[0], -L[1], L[2]))
    diffuse = np.array(FLOOR.diffuse) * L[2]
    specular = np.array(FLOOR.specular) * max(0.0, R @ V) ** FLOOR.exponent
    expected = np.array(FLOOR.ambient) * 0.1 + (diffuse + specular) * radiance
    # The field of view of 0.01 degrees moves p by less than 1e-3 across the pixel.
    assert np.allclose(image[0, 0], expected, rtol=1e-3), f"{image[0, 0]} is not {expected}"


def test_diffuse_floor_under_a_square_light_is_its_integral(active: str, settings: Any):
    floor = Material(diffuse=(0.8, 0.4, 0.2))
    bodies = [
        Body("square", (0.0, 0.0, 0.0), 50.0, floor),
        Body("square", (0.5, 0.5, 1.5), 0.7, Material(), (3.0, 2.0, 1.0)),
    ]
    scene = scene_description(bodies, fov=0.01, target=DOWNWARDS)
    loaded = load(scene, settings("haste", 1), active)
    images = np.stack([render(loaded, seed, 4096)[0][0, 0] for seed in range(16)])
    eye, target = np.array(EYE), np.array(DOWNWARDS)
    p = eye + (target - eye) * (eye[2] / (eye[2] - target[2]))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x, y = np.meshgrid(0.5 + 0.7 * nodes - p[0], 0.5 + 0.7 * nodes - p[1])
    # k_d times the mean over the light of the cosine on the floor: no falloff (equation 4).
    mean = np.sum(0.25 * np.outer(weights, weights) * 1.5 / np.sqrt(x**2 + y**2 + 1.5**2))
    expected = np.array(floor.diffuse) * (3.0, 2.0, 1.0) * mean
    error = images.std(axis=0, ddof=1) / 4.0
    assert np.all(np.abs(images.mean(axis=0) - expected) < 5.0 * error + 1e-3 * expected), (
        f"{images.mean(axis=0)} +- {error} is not {expected}"
    )
    assert np.all(error < 0.01 * expected)


@pytest.mark.parametrize("model", ["haste", "whitted"])
@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"sky": {"type": "constant"}}, "sky"),
        ({"extra": {"type": "sphere", "bsdf": {"type": "conductor", "material": "Au"}}}, "extra"),
    ],
)
def test_what_the_models_do_not_know_is_refused(
    active: str, settings: Any, model: str, changes: dict[str, Any], word: str
):
    from harness.scene import SceneError

    with pytest.raises(SceneError, match=word):
        load(scene_description(BODIES) | changes, settings(model), active)


def test_a_floor_without_lights_is_black_but_for_the_ambient_constant(active: str, settings: Any):
    bodies = [replace(BODIES[0], radiance=BLACK)]
    image, _ = render(load(scene_description(bodies), settings("haste"), active), 0, 4)
    assert image.max() == 0.0
