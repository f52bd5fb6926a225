"""The scenes with known answers: what they claim, what is not exact in them, who agrees."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from harness.answers import judge_error
from harness.scene import RenderSettings, Scene, check_model, load_scene, load_settings
from harness.statistics.bias import Verdict, image_means
from harness.statistics.metrics import luminance
from harness.tables.answers import relative_error
from harness.tracers.haste import HasteCpu
from reference.analytic import ANSWERS, AnswerError, answer, forms
from reference.analytic.view import look, triangle_areas, triangles_of

ROOT = Path(__file__).parents[3] / "scenes" / "analytic"
NAMES = sorted(path.parent.name for path in ROOT.glob("*/scene.xml"))
MODELS = ("path", "haste", "whitted")
CLAIMS = [(name, model) for name in NAMES for model in load_settings(ROOT / name).models]
SEEDS = 8
SPP = {"path": 128, "haste": 64, "whitted": 8}
LEVEL = 1.0 - 1e-6
"""Of each interval, so that all together err about once in thirty thousand runs of the suite."""
GEOMETRY = 5e-4
"""What patches and polygons may add to an error; reference/analytic/README.md."""

Array = NDArray[np.float64]


@cache
def scene_of(name: str) -> Scene:
    return load_scene(ROOT / name)


def settings_of(name: str, model: str, **changes: object) -> RenderSettings:
    settings = load_settings(ROOT / name).render(model)  # type: ignore[arg-type]
    return replace(settings, **changes)  # type: ignore[arg-type]


def known(name: str, model: str, **changes: object) -> Array:
    key = load_settings(ROOT / name).answer
    found = answer(key, scene_of(name), settings_of(name, model, **changes))
    assert found is not None, (name, model)
    return np.array(found)


@cache
def rendered(name: str, model: str) -> Array:
    """Mean luminance of independent images by haste-cpu."""
    tracer = HasteCpu(2)
    tracer.load(ROOT / name, settings_of(name, model))
    images = [tracer.render(seed, SPP[model]).image for seed in range(SEEDS)]
    return image_means(np.stack(images).astype(np.float64))


def test_every_answer_has_its_scene() -> None:
    assert {load_settings(ROOT / name).answer for name in NAMES} == set(ANSWERS)
    assert all(load_settings(ROOT / name).answer == name.replace("-", "_") for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_claims_exactly_the_models_that_have_an_answer(name: str) -> None:
    settings = load_settings(ROOT / name)
    for model in MODELS:
        found = answer(settings.answer, scene_of(name), settings.render(model))
        assert (found is not None) == (model in settings.models), (name, model, found)
        if found is not None:
            check_model(scene_of(name), model)
            assert min(found) > 0.0, (name, model, found)


@pytest.mark.parametrize(("name", "model"), CLAIMS)
def test_haste_cpu_shows_the_known_radiance(name: str, model: str) -> None:
    expected = float(luminance(known(name, model)))
    errors = rendered(name, model) / expected - 1.0
    half = stats.t.ppf(0.5 + 0.5 * LEVEL, SEEDS - 1) * errors.std(ddof=1) / math.sqrt(SEEDS)
    assert abs(errors.mean()) < half + GEOMETRY, (
        f"{name} {model}: known {expected}, error {errors.mean():+.4%} ± {half:.4%}"
    )


@pytest.mark.parametrize("planted", [0.995, 1.005])
@pytest.mark.parametrize(
    ("name", "model"),
    [("sphere-light", "haste"), ("mirror-box", "path"), ("integrating-sphere", "whitted")],
)
def test_an_answer_that_is_half_a_per_cent_off_fails(name: str, model: str, planted: float) -> None:
    expected = float(luminance(known(name, model)))
    right = relative_error(rendered(name, model), expected)
    wrong = relative_error(rendered(name, model), expected * planted)
    assert judge_error(right) is Verdict.PASS, right
    assert judge_error(wrong) is Verdict.FAIL, wrong


def test_the_numbers_of_the_files_stated_once_more() -> None:
    cosine = 1.6 / 2.0
    rho, light = np.array([0.6, 0.5, 0.3]), np.array([10.0, 9.0, 8.0])
    assert known("sphere-light", "path") == pytest.approx(
        rho * light * (0.5 / 2.0) ** 2 * cosine, rel=1e-6
    )
    assert known("sphere-light", "haste") == pytest.approx(
        rho * light * (1.0 - 0.25 / 20.0) * cosine, rel=1e-6
    )
    assert known("sphere-light", "whitted") == pytest.approx(rho * (light * cosine + 0.1), rel=1e-6)
    grey = 0.5 * light * (1.44 / (1.44 + 9.0) - 0.04)
    assert known("soft-shadow", "path") == pytest.approx(grey, rel=1e-6)
    assert known("soft-shadow", "whitted") == pytest.approx(np.full(3, 0.05), rel=1e-6)
    assert known("emitting-box", "path") == pytest.approx(
        [(1 - 0.8**8) / 0.2, 0.9 * (1 - 0.5**8) / 0.5, 0.8 * (1 - 0.2**8) / 0.8], rel=1e-6
    )
    series = sum(0.8**k for k in range(1, 8)) * 0.5
    assert known("integrating-sphere", "path")[0] == pytest.approx(series, rel=1e-6)
    endless = 0.5 * (1.0 + 1.0 / math.sqrt(5.0)) * 0.5
    assert known("wall-sky", "path")[0] == pytest.approx(endless, rel=5e-3)


@pytest.mark.parametrize(
    ("name", "model", "depths"),
    [("mirror-box", "haste", "max_layers"), ("emitting-box", "path", "max_depth")],
)
def test_an_answer_follows_the_depth_of_the_settings(name: str, model: str, depths: str) -> None:
    single, double = (known(name, model, **{depths: depth}) for depth in (1, 2))
    factor = 0.8 if name == "mirror-box" else np.array([0.8, 0.5, 0.2])
    assert double == pytest.approx(single * (1.0 + factor), rel=1e-6)


def moved(scene: Scene, x: float, y: float) -> Scene:
    """The scene with the place (x, y) of the film in the film's middle."""
    camera = scene.camera
    corner = np.array(camera.corner)
    corner += (x - 0.5) * camera.width * np.array(camera.dx)
    corner += (y - 0.5) * camera.height * np.array(camera.dy)
    return replace(scene, camera=replace(camera, corner=tuple(corner.tolist())))


@pytest.mark.parametrize("name", ["sphere-light", "rectangle-light", "highlight", "wall-sky"])
def test_a_patch_shows_the_answer_of_its_middle(name: str) -> None:
    key = load_settings(ROOT / name).answer
    nodes, weights = np.polynomial.legendre.leggauss(3)
    for model in load_settings(ROOT / name).models:
        middle = known(name, model)
        mean = np.zeros(3)
        for x, w_x in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
            for y, w_y in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
                at = moved(scene_of(name), x, y)
                mean += w_x * w_y * np.array(answer(key, at, settings_of(name, model)))
        assert np.abs(mean / middle - 1.0).max() < 1e-4, (name, model, mean, middle)


@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("disk-light", 2.0),
        ("soft-shadow", 1.2),
        ("integrating-sphere", 1.0),
        ("ambient-dome", 0.8),
        ("glass-slab", 1.25),
    ],
)
def test_a_patch_on_an_axis_is_small_beside_everything(name: str, nearest: float) -> None:
    # Nothing is linear in the offset from an axis of symmetry: what is left is of the order of its
    # square, a third of a corner's in the mean, over that of the distance to the nearest shape.
    scene = scene_of(name)
    middle = look(scene).point
    reach = max(np.linalg.norm(look(scene, x, y).point - middle) for x in (0, 1) for y in (0, 1))
    assert reach**2 / (3.0 * nearest**2) < 3e-5, (name, reach)


def test_a_disk_of_many_sides_is_a_disk() -> None:
    scene = scene_of("disk-light")
    corners = triangles_of(scene, scene.shapes[scene.lights[0].shape])
    hit = look(scene)
    polygon = forms.polygon_share(hit.point, hit.normal, corners).sum()
    assert polygon == pytest.approx(forms.disk_share(1.0, 2.0), rel=1e-5)


def test_the_polygons_of_the_integrating_sphere_cost_what_the_readme_says() -> None:
    scene = scene_of("integrating-sphere")
    bright, dark = (triangles_of(scene, shape) for shape in scene.shapes)
    assert len(bright) == len(dark) == 16_384
    areas = [triangle_areas(corners).sum() for corners in (bright, dark)]
    assert areas == pytest.approx([2.0 * math.pi] * 2, rel=3e-4)
    at_pole = []
    for place in (0.2, 0.8):
        hit = look(scene, place, 0.3)
        at_pole.append(forms.polygon_share(hit.point, hit.normal, bright).sum())
        assert hit.normal[2] > 1.0 - 2e-4
    assert at_pole == pytest.approx([0.5, 0.5], rel=3e-4)
    random = np.random.default_rng(1)
    shares = []
    for corners in dark[random.integers(0, len(dark), 60)]:
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.linalg.norm(normal)
        middle = corners.mean(axis=0)
        assert normal @ middle < 0.0, "the dark half must face inwards"
        shares.append(forms.polygon_share(middle, normal, bright).sum())
    assert np.mean(shares) == pytest.approx(0.5, rel=3e-3)


def bare_sphere_answers(samples: int) -> dict[str, tuple[float, float]]:
    """Means and standard errors of `haste` in a true sphere, by equations 4 and 6 alone."""
    random = np.random.default_rng(7)
    pole = np.array([0.0, 0.0, -1.0])

    def on_sphere(count: int) -> Array:
        points = random.normal(size=(count, 3))
        return points / np.linalg.norm(points, axis=1, keepdims=True)

    lit = on_sphere(samples)
    lit[:, 2] = np.abs(lit[:, 2])
    arms = lit - pole
    direct = arms @ -pole / np.linalg.norm(arms, axis=1)
    directions = on_sphere(samples)
    directions[:, 2] = np.abs(directions[:, 2])
    wall = pole + 2.0 * directions[:, 2:] * directions
    to_light = np.array([0.0, 0.0, 0.5]) - wall
    cosines = -(to_light * wall).sum(axis=1) / np.linalg.norm(to_light, axis=1)
    ambient = np.where(wall[:, 2] < 0.0, cosines, 0.0)
    return {
        name: (float(values.mean()), float(values.std() / math.sqrt(samples)))
        for name, values in (("direct", direct), ("ambient", ambient))
    }


def test_the_integrating_sphere_of_haste_by_drawing_its_samples() -> None:
    estimates = bare_sphere_answers(400_000)
    colour, light = np.array([0.8, 0.7, 0.6]), np.array([1.0, 0.9, 0.8])
    direct, ambient = estimates["direct"], estimates["ambient"]
    drawn = colour * light * (direct[0] + colour * ambient[0])
    spread = 5.0 * (direct[1] + ambient[1]) / direct[0]
    assert known("integrating-sphere", "haste") == pytest.approx(drawn, rel=spread)


def test_the_ambient_dome_by_drawing_its_samples() -> None:
    random = np.random.default_rng(11)
    directions = random.normal(size=(400_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    directions[:, 2] = np.abs(directions[:, 2])
    wall = 2.0 * directions
    lamp = np.array([0.0, 0.0, 1.0])
    arms = (lamp - wall) / np.linalg.norm(lamp - wall, axis=1, keepdims=True)
    normal = -directions
    cosines = (arms * normal).sum(axis=1)
    mirrored = 2.0 * cosines[:, None] * normal - arms
    lobes = np.maximum((mirrored * -directions).sum(axis=1), 0.0) ** 10
    on_lamp = np.linalg.norm(np.cross(directions, lamp), axis=1) < 0.2
    reflected = np.outer(cosines, [0.5, 0.4, 0.3]) + np.outer(lobes, [0.3, 0.4, 0.5])
    reflected[on_lamp] = 0.0
    drawn = reflected.mean(axis=0) * [0.9, 0.8, 0.7] * np.array([1.0, 0.9, 0.8])
    spread = 5.0 * (reflected.std(axis=0) / reflected.mean(axis=0)).max() / math.sqrt(400_000)
    assert known("ambient-dome", "haste") == pytest.approx(drawn, rel=spread)


@pytest.mark.parametrize(
    ("key", "name", "message"),
    [
        ("sphere_light", "disk-light", 'shape "light" must be a sphere'),
        ("disk_light", "rectangle-light", "the disk must be parallel to the floor"),
        ("rectangle_light", "disk-light", "the light must be a rectangle that faces the floor"),
        ("soft_shadow", "disk-light", "one sphere must cast the shadow, not 0"),
        ("wall_sky", "sphere-light", "a constant environment must be the only light"),
        ("furnace_diffuse", "furnace-mirror", "the object must be convex and diffuse"),
        ("furnace_mirror", "furnace-diffuse", "the object must be a convex mirror"),
        ("furnace_glass", "furnace-mirror", "the object must be a sphere of glass"),
        ("furnace_phong", "wall-sky", "one object under a constant environment is needed"),
        ("emitting_box", "mirror-box", "the walls must be diffuse"),
        ("mirror_box", "emitting-box", "the walls must do nothing but mirror and emit"),
        ("integrating_sphere", "sphere-light", "the pole of the dark half"),
        ("glass_slab", "sphere-light", "a slab of glass head-on before a black light is needed"),
    ],
)
def test_a_scene_of_another_form_is_refused(key: str, name: str, message: str) -> None:
    with pytest.raises(AnswerError, match=message):
        answer(key, scene_of(name), settings_of(name, "path"))


def test_an_unknown_answer_is_refused_by_name() -> None:
    with pytest.raises(AnswerError, match='no answer is called "sphere"; known are sphere_light'):
        answer("sphere", scene_of("sphere-light"), settings_of("sphere-light", "path"))
