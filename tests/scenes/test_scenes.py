"""The scenes that are shipped: complete, reproducible, and fit for what they are for."""

from __future__ import annotations

import importlib
from dataclasses import fields
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from harness.scene import Features, Scene, active_variant, check_model, load_scene, load_settings

SCENES = Path(__file__).parents[2] / "scenes"
NAMES = ("cornell-box", "three-spheres", "skull", "mirror-glass", "hard")


@pytest.fixture(scope="module")
def scenes() -> dict[str, Scene]:
    return {name: load_scene(SCENES / name, 64, 64) for name in NAMES}


def test_every_folder_with_a_scene_is_tested() -> None:
    assert {file.parent.name for file in SCENES.glob("*/scene.xml")} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_is_complete_and_renders_with_every_model(
    name: str, scenes: dict[str, Scene]
) -> None:
    settings = load_settings(SCENES / name)
    assert settings.title
    assert set(settings.models) == {"path", "haste", "whitted"}
    assert settings.rr_depth > settings.max_depth
    for model in settings.models:
        check_model(scenes[name], model)
    readme = (SCENES / name / "README.md").read_text()
    assert "licence" in readme.lower()
    assert "**Exercises**" in readme or "what it catches" in readme


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_is_of_unit_scale_near_the_origin(name: str, scenes: dict[str, Scene]) -> None:
    scene = scenes[name]
    centres, radii = scene.spheres[:, :3], scene.spheres[:, 3:]
    points = np.concatenate([scene.vertices, centres - radii, centres + radii])
    assert np.abs(points).max() < 16.0
    assert np.linalg.norm(scene.camera.origin) < 8.0


@pytest.mark.parametrize("name", ["cornell-box", "mirror-glass"])
def test_a_scene_of_mitsubas_plugins_loads_with_mitsuba_alone(name: str) -> None:
    with active_variant("scalar_rgb"):
        built = mi.load_file(str(SCENES / name / "scene.xml"))
        assert built.integrator() is not None


def test_the_scenes_together_use_every_feature_but_the_environment(
    scenes: dict[str, Scene],
) -> None:
    used = {feature for scene in scenes.values() for feature in scene.features.names()}
    assert used == {field.name for field in fields(Features)} - {"environment"}


def test_the_hard_scene_alone_uses_every_feature_but_the_environment(
    scenes: dict[str, Scene],
) -> None:
    hard = scenes["hard"]
    assert set(hard.features.names()) == {field.name for field in fields(Features)} - {
        "environment"
    }
    assert any(
        material.kind == "phong" and material.ambient != material.diffuse
        for material in hard.materials
    )
    bent = next(shape for shape in hard.shapes if shape.name == "bent-light")
    assert bent.light >= 0
    assert not bent.smooth


@pytest.mark.parametrize("generator", ["cornell_box", "hard"])
def test_generators_write_the_committed_assets_again(
    generator: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(SCENES / "generators"))
    module = importlib.import_module(generator)
    module.main(tmp_path)
    written = sorted(tmp_path.glob("*.ply"))
    assert [file.name for file in written] == [
        file.name for file in sorted(module.ASSETS.glob("*"))
    ]
    for file in written:
        assert file.read_bytes() == (module.ASSETS / file.name).read_bytes(), file.name


def test_the_cornell_box_has_the_measured_coordinates(scenes: dict[str, Scene]) -> None:
    scene = scenes["cornell-box"]
    millimetres = scene.vertices.astype(np.float64) / 0.0036 + [278.0, 274.4, 279.6]
    for corner in [(552.8, 0, 0), (556, 548.8, 559.2), (343, 548.3, 227), (314, 330, 456)]:
        distance = np.linalg.norm(millimetres - corner, axis=1).min()
        # float32 near 1, in millimetres.
        assert distance < 2.0**-23 / 0.0036 * 2, (corner, distance)
    camera = np.array(scene.camera.origin) / 0.0036 + [278.0, 274.4, 279.6]
    assert camera == pytest.approx([278.0, 273.0, -800.0], abs=1e-9)


def test_the_skull_is_watertight_and_faces_outwards(scenes: dict[str, Scene]) -> None:
    scene = scenes["skull"]
    shape = next(shape for shape in scene.shapes if shape.name == "skull")
    assert shape.smooth
    assert shape.count == 37_844
    triangles = scene.triangles[shape.first : shape.first + shape.count].astype(np.int64)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forwards = edges[:, 0] * len(scene.vertices) + edges[:, 1]
    backwards = edges[:, 1] * len(scene.vertices) + edges[:, 0]
    assert len(np.unique(forwards)) == len(forwards)
    assert np.array_equal(np.sort(forwards), np.sort(backwards))
    corners = scene.vertices[triangles].astype(np.float64)
    volume = np.einsum("tx,tx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume > 0.0
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    agree = np.einsum("tcx,tx->tc", scene.normals[triangles], faces) > 0.0
    assert agree.mean() > 0.999


def test_the_skulls_asset_is_small_and_its_source_is_named() -> None:
    assert (SCENES / "skull" / "assets" / "skull.ply").stat().st_size < 1_500_000
    readme = (SCENES / "skull" / "README.md").read_text()
    for expected in ("libcgal-demo", "5.5.1-2", "7a9147c819e426fb", "CC0"):
        assert expected in readme


def test_no_other_licence_hides_in_the_assets() -> None:
    total = sum(file.stat().st_size for file in SCENES.rglob("assets/*"))
    assert total < 2_000_000
