"""The scenes that are shipped: complete, reproducible, and fit for what they are for."""

from __future__ import annotations

import importlib
import io
import subprocess
from dataclasses import fields
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from PIL import Image as PillowImage

from harness.measure.config import load_config
from harness.scene import Features, Scene, active_variant, check_model, load_scene, load_settings
from harness.scene.camera import read_camera
from harness.scene.parse import parse_scene
from harness.thumbnails import MAX_BYTES, thumbnail_size

REPOSITORY = Path(__file__).parents[2]
SCENES = REPOSITORY / "scenes"
STANDARD = (
    "armadillo",
    "balls",
    "bunny",
    "cart",
    "cornell-box",
    "hard",
    "head",
    "menger-1",
    "menger-2",
    "menger-3",
    "menger-4",
    "mirror-glass",
    "skull",
    "sphereflake",
    "teapot",
    "teapot-stadium",
    "tetra",
    "three-spheres",
    "veach-mis",
)
ANALYTIC = tuple(
    sorted(f"analytic/{file.parent.name}" for file in SCENES.glob("analytic/*/scene.xml"))
)
NAMES = (*STANDARD, *ANALYTIC)

FOR_RAYS = {"bumpy-16k": 16_384, "bumpy-262k": 262_144, "bumpy-4m": 4_194_304}
"""Triangles of the scenes that the benchmark of rays alone uses."""

COUNTS = {
    "armadillo": (52_006, 0),
    "balls": (2, 7_384),
    "bunny": (75_414, 0),
    "cart": (30_050, 0),
    "cornell-box": (32, 0),
    "hard": (126, 3),
    "head": (25_896, 0),
    "menger-1": (150, 0),
    "menger-2": (2_118, 0),
    "menger-3": (36_102, 0),
    "menger-4": (672_774, 0),
    "mirror-glass": (12, 2),
    "skull": (37_850, 0),
    "sphereflake": (4, 7_382),
    "teapot": (2_328, 2),
    "teapot-stadium": (39_390, 0),
    "tetra": (4_096, 1),
    "three-spheres": (4, 3),
    "veach-mis": (12, 5),
}
"""Triangles and spheres of each standard scene, lights and floors included."""

MITSUBA_ALONE = ("cornell-box", "mirror-glass", "tetra")
"""Standard scenes without `phong`."""


@pytest.fixture(scope="module")
def scenes() -> dict[str, Scene]:
    return {name: load_scene(SCENES / name, 64, 64) for name in NAMES}


def bounds(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates of everything in a scene."""
    centres, radii = scene.spheres[:, :3], scene.spheres[:, 3:]
    points = np.concatenate([scene.vertices, centres - radii, centres + radii]).astype(np.float64)
    return points.min(axis=0), points.max(axis=0)


def test_every_folder_with_a_scene_is_tested() -> None:
    found = {file.parent.relative_to(SCENES).as_posix() for file in SCENES.rglob("scene.xml")}
    assert found == {*NAMES, *FOR_RAYS}


@pytest.mark.parametrize("name", FOR_RAYS)
def test_a_scene_for_rays_is_described_with_its_number_of_triangles(name: str) -> None:
    readme, table = ((SCENES / name / "README.md").read_text(), (SCENES / "README.md").read_text())
    assert readme.startswith("# ") and "licence" in readme and "**Exercises**" in readme
    assert f"{FOR_RAYS[name]:,} triangles" in readme
    assert f"[{name}]({name}/README.md) | {FOR_RAYS[name]:,} | 0 |" in table
    header = (SCENES / name / "assets" / f"{name}.ply").read_bytes()[:400]
    assert f"element face {FOR_RAYS[name]}\n".encode() in header


def test_no_preset_renders_images_of_a_scene_for_rays() -> None:
    presets = [load_config(file) for file in (REPOSITORY / "config").glob("*.yaml")]
    assert presets
    for config in presets:
        assert not set(config.scenes) & set(FOR_RAYS), config["preset"]


def test_a_bumpy_sphere_imports_as_one_mesh_under_a_sky() -> None:
    scene = load_scene(SCENES / "bumpy-16k")
    assert (len(scene.triangles), len(scene.spheres), len(scene.shapes)) == (16_384, 0, 1)
    assert not scene.lights and scene.environment is not None
    check_model(scene, "path")
    assert load_settings(SCENES / "bumpy-16k").rays_inside
    distance = np.linalg.norm(scene.camera.origin)
    assert distance > 1.13, "the camera is outside: the surface ends at 1 + 0.1 + 0.02"


def test_no_two_scenes_have_the_same_name() -> None:
    last = [Path(name).name for name in NAMES]
    assert len(set(last)) == len(last), sorted(name for name in last if last.count(name) > 1)


@pytest.mark.parametrize("name", NAMES)
def test_a_scene_renders_with_every_model_that_it_claims(
    name: str, scenes: dict[str, Scene]
) -> None:
    settings = load_settings(SCENES / name)
    assert settings.title
    assert settings.rr_depth > settings.max_depth
    for model in settings.models:
        check_model(scenes[name], model)


@pytest.mark.parametrize("name", STANDARD)
def test_a_standard_scene_claims_every_model(name: str) -> None:
    # Mitsuba takes seconds to begin each image of thousands of spheres, and longest in `haste`.
    claimed = {"sphereflake": {"path", "whitted"}, "balls": {"path"}}
    models = set(load_settings(SCENES / name).models)
    assert models == claimed.get(name, {"path", "haste", "whitted"})


@pytest.mark.parametrize("name", NAMES)
def test_a_readme_names_purpose_source_and_licence(name: str) -> None:
    readme = (SCENES / name / "README.md").read_text()
    assert readme.startswith("# ")
    assert "licence" in readme.lower()
    if name in STANDARD:
        assert "**Exercises**" in readme or "what it catches" in readme
        table = (SCENES / "README.md").read_text()
        triangles, spheres = COUNTS[name]
        assert f"[{name}]({name}/README.md) | {triangles:,} | {spheres:,} |" in table


@pytest.mark.parametrize("name", STANDARD)
def test_a_readme_shows_a_small_thumbnail(name: str) -> None:
    assert "![" in (SCENES / name / "README.md").read_text()
    assert "](thumbnail.png)" in (SCENES / name / "README.md").read_text()
    data = (SCENES / name / "thumbnail.png").read_bytes()
    assert len(data) <= MAX_BYTES
    picture = PillowImage.open(io.BytesIO(data))
    assert picture.size == thumbnail_size(load_settings(SCENES / name).picture)
    # A black or blank picture shows nothing.
    assert np.asarray(picture.convert("L"), float).std() > 10.0


@pytest.mark.parametrize("name", STANDARD)
def test_a_standard_scene_has_the_triangles_and_spheres_that_are_stated(
    name: str, scenes: dict[str, Scene]
) -> None:
    scene = scenes[name]
    assert (len(scene.triangles), len(scene.spheres)) == COUNTS[name]


@pytest.mark.parametrize("name", NAMES)
def test_every_light_shines_and_has_an_area(name: str, scenes: dict[str, Scene]) -> None:
    scene = scenes[name]
    assert scene.lights or scene.environment is not None
    for light in scene.lights:
        shape = scene.shapes[light.shape]
        assert max(light.radiance) > 0.0, shape.name
        if shape.kind == "sphere":
            assert scene.spheres[shape.first, 3] > 0.0, shape.name
            continue
        corners = scene.vertices[scene.triangles[shape.first : shape.first + shape.count]]
        edges = corners[:, 1:].astype(np.float64) - corners[:, :1]
        area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
        assert area > 0.0, shape.name


@pytest.mark.parametrize("name", NAMES)
def test_normals_agree_with_the_winding(name: str, scenes: dict[str, Scene]) -> None:
    scene = scenes[name]
    for shape in scene.shapes:
        if not shape.smooth:
            continue
        triangles = scene.triangles[shape.first : shape.first + shape.count]
        corners = scene.vertices[triangles].astype(np.float64)
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        agree = np.einsum("tcx,tx->tc", scene.normals[triangles], faces) > 0.0
        assert agree.mean() > 0.99, (shape.name, agree.mean())


@pytest.mark.parametrize("name", STANDARD)
def test_the_camera_is_outside_of_every_sphere(name: str, scenes: dict[str, Scene]) -> None:
    scene = scenes[name]
    distances = np.linalg.norm(scene.spheres[:, :3] - np.array(scene.camera.origin), axis=1)
    inside = np.flatnonzero(distances < scene.spheres[:, 3])
    assert not inside.size, [scene.shapes[scene.sphere_shape[index]].name for index in inside]


@pytest.mark.parametrize("name", sorted(set(STANDARD) - {"teapot-stadium"}))
def test_a_scene_is_of_unit_scale_near_the_origin(name: str, scenes: dict[str, Scene]) -> None:
    low, high = bounds(scenes[name])
    assert max(np.abs(low).max(), np.abs(high).max()) < 16.0
    assert np.linalg.norm(scenes[name].camera.origin) < 11.0


def test_the_stadium_is_a_thousand_times_as_large_as_the_teapot(scenes: dict[str, Scene]) -> None:
    scene = scenes["teapot-stadium"]

    def width(name: str) -> float:
        shape = next(shape for shape in scene.shapes if shape.name == name)
        used = scene.vertices[scene.triangles[shape.first : shape.first + shape.count]]
        return float(np.ptp(used[..., 0]))

    assert 0.2 < width("pot") < 0.4
    assert 200.0 < width("upper-stand") < 400.0


@pytest.mark.parametrize("name", ["cart", "three-spheres"])
def test_the_hash_of_a_scene_depends_on_nothing_but_its_content(
    name: str, scenes: dict[str, Scene]
) -> None:
    assert load_scene(SCENES / name, 32, 32).sha256 == scenes[name].sha256


def test_no_two_scenes_have_the_same_hash(scenes: dict[str, Scene]) -> None:
    assert len({scene.sha256 for scene in scenes.values()}) == len(NAMES)


@pytest.mark.parametrize("name", MITSUBA_ALONE)
def test_a_scene_of_mitsubas_plugins_loads_with_mitsuba_alone(name: str) -> None:
    with active_variant("scalar_rgb"):
        built = mi.load_file(str(SCENES / name / "scene.xml"))
        assert built.integrator() is not None


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


@pytest.mark.parametrize(
    ("name", "shape_name", "triangle_count"),
    [
        ("armadillo", "armadillo", 52_000),
        ("bunny", "bunny", 75_408),
        ("skull", "skull", 37_844),
    ],
)
def test_a_scan_is_watertight_and_faces_outwards(
    name: str, shape_name: str, triangle_count: int, scenes: dict[str, Scene]
) -> None:
    scene = scenes[name]
    shape = next(shape for shape in scene.shapes if shape.name == shape_name)
    assert shape.smooth
    assert shape.count == triangle_count
    triangles = scene.triangles[shape.first : shape.first + shape.count].astype(np.int64)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forwards = edges[:, 0] * len(scene.vertices) + edges[:, 1]
    backwards = edges[:, 1] * len(scene.vertices) + edges[:, 0]
    assert len(np.unique(forwards)) == len(forwards)
    assert np.array_equal(np.sort(forwards), np.sort(backwards))
    corners = scene.vertices[triangles].astype(np.float64)
    volume = np.einsum("tx,tx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume > 0.0


def test_the_haines_cameras_see_513_by_513_corners_within_45_degrees() -> None:
    origins = {
        "balls": (2.1, 1.3, 1.7),
        "teapot": (4.86, 7.2, 5.4),
        "tetra": (1.022846, -3.177154, -2.174512),
    }
    for name, origin in origins.items():
        camera = read_camera(parse_scene(SCENES / name, "scalar_rgb"))
        assert (camera.width, camera.height) == (512, 512)
        assert camera.origin == pytest.approx(origin, abs=1e-6)
        width = camera.width * np.linalg.norm(camera.dx)
        assert width == pytest.approx(2.0 * np.tan(np.radians(22.5)), rel=1e-6)
        assert load_settings(SCENES / name).eye_rays is not None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("skull", ("libcgal-demo", "5.5.1-2", "7a9147c819e426fb", "CC0")),
        ("bunny", ("libcgal-demo", "5.5.1-2", "ab651cb04955c161", "Stanford")),
        ("armadillo", ("libcgal-demo", "5.5.1-2", "6f7f3ca1abc50656", "Stanford")),
        ("head", ("libcgal-demo", "5.5.1-2", "9424b7132b587669", "CC0")),
        ("tetra", ("tachyon-doc", "0.99~b6+dsx-10", "c11fffff6eee12e0", "BSD")),
        ("teapot", ("tachyon-doc", "0.99~b6+dsx-10", "d685aa903d652f9c", "BSD")),
    ],
)
def test_the_source_of_a_mesh_is_named(name: str, expected: tuple[str, ...]) -> None:
    readme = (SCENES / name / "README.md").read_text()
    missing = [word for word in expected if word not in readme]
    assert not missing, missing


def test_the_committed_meshes_are_small() -> None:
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z", "scenes"],
        cwd=REPOSITORY,
        capture_output=True,
        check=True,
    )
    files = [REPOSITORY / name for name in listed.stdout.decode().split("\0") if name]
    meshes = sum(file.stat().st_size for file in files if file.suffix == ".ply")
    assert meshes < 4_000_000
    assert sum(file.stat().st_size for file in files) < 5_000_000
