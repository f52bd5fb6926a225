"""Generated meshes: closed forms of counts, areas and volumes, and the same bytes each time."""

from __future__ import annotations

import importlib
import itertools
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml

from harness.generate import write_files
from harness.measure.inputs import files_of_scene
from harness.scene import SceneError, generated, load_scene
from harness.scene.generated import SCENES, generated_in, generated_scenes

CHEAP = sorted(set(generated_scenes()) - {"menger-4", "bumpy-262k", "bumpy-4m"})


@pytest.fixture
def generator(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """Import a module of scenes/generators."""
    monkeypatch.syspath_prepend(str(SCENES / "generators"))
    return importlib.import_module


def doubled_areas(corners: np.ndarray) -> np.ndarray:
    """Normals of triangles [T, 3, 3], as long as twice their area."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def volume(corners: np.ndarray) -> float:
    return float(np.einsum("tx,tx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)


@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_a_sponge_has_the_count_area_and_volume_of_its_level(
    level: int, generator: Callable[[str], ModuleType]
) -> None:
    points, triangles = generator("menger").sponge(level)
    corners = points[triangles]
    assert len(triangles) == 2 * (2 * 20**level + 4 * 8**level)
    # The cube [-1, 1]^3 has faces of 4 and a volume of 8.
    area = 0.5 * np.linalg.norm(doubled_areas(corners), axis=1).sum()
    assert area == pytest.approx(
        4.0 * (2.0 * (20 / 9) ** level + 4.0 * (8 / 9) ** level), rel=1e-12
    )
    assert volume(corners) == pytest.approx(8.0 * (20 / 27) ** level, rel=1e-12)


def test_a_sponge_of_level_4_has_the_published_count() -> None:
    header = (SCENES / "menger-4" / "assets" / "menger-4.ply").read_bytes()[:400]
    assert b"element face 672768\n" in header


@pytest.mark.parametrize("rings", [8, 64])
def test_a_bumpy_sphere_is_closed_faces_outwards_and_has_no_degenerate_triangle(
    rings: int, generator: Callable[[str], ModuleType]
) -> None:
    points, triangles = generator("bumpy").bumpy_sphere(rings)
    assert len(triangles) == 4 * rings**2 and len(points) == 2 * rings**2 + 2
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forwards = edges[:, 0] * len(points) + edges[:, 1]
    backwards = edges[:, 1] * len(points) + edges[:, 0]
    assert len(np.unique(forwards)) == len(forwards)
    assert np.array_equal(np.sort(forwards), np.sort(backwards))
    corners = points[triangles].astype(np.float32).astype(np.float64)
    assert np.linalg.norm(doubled_areas(corners), axis=1).min() > 0.0
    # A star about the centre: every triangle spans a positive volume with it.
    spanned = np.einsum("tx,tx->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    assert spanned.min() > 0.0


def test_a_bumpy_sphere_has_the_radius_that_is_stated(
    generator: Callable[[str], ModuleType],
) -> None:
    bumpy = generator("bumpy")
    points, _ = bumpy.bumpy_sphere(64)
    body, poles = points[:-2], points[-2:]
    radius = np.linalg.norm(body, axis=1)
    u, v = np.arctan2(body[:, 1], body[:, 0]), np.arccos(body[:, 2] / radius)
    waves = 0.1 * np.sin(20 * u) * np.sin(20 * v) + 0.02 * np.sin(97 * u + 3) * np.cos(83 * v)
    # The angles are read back to 1e-15, and the waves have slopes below 4.
    np.testing.assert_allclose(radius, 1.0 + waves, atol=1e-12)
    np.testing.assert_allclose(poles, [[0, 0, 1], [0, 0, -1]])


def test_the_sphereflake_has_nine_touching_children_a_sphere(
    generator: Callable[[str], ModuleType],
) -> None:
    generations = generator("sphereflake").sphereflake(4)
    assert [len(spheres) for spheres in generations] == [1, 9, 81, 729, 6561]
    for parents, children in itertools.pairwise(generations):
        owners = np.repeat(parents, 9, axis=0)
        assert children[:, 3] == pytest.approx(owners[:, 3] / 3.0, rel=1e-12)
        distances = np.linalg.norm(children[:, :3] - owners[:, :3], axis=1)
        assert distances == pytest.approx(owners[:, 3] + children[:, 3], rel=1e-12)


def test_the_sphereflake_has_the_coordinates_of_the_published_database(
    generator: Callable[[str], ModuleType],
) -> None:
    first, second = generator("sphereflake").sphereflake(2)[1:]
    expected = np.array(
        [
            (0.272166, 0.272166, 0.544331, 0.166667),
            (0.643951, 0.172546, 0.0, 0.166667),
            (-0.172546, -0.643951, 0.0, 0.166667),
            (0.420314, 0.420314, 0.618405, 0.0555556),
        ]
    )
    made = np.concatenate([first, second])
    distances = np.linalg.norm(made[None] - expected[:, None], axis=2).min(axis=1)
    assert distances.max() < 1e-6, distances


def test_every_solid_of_the_workshop_faces_outwards(
    generator: Callable[[str], ModuleType],
) -> None:
    solids = generator("solids")
    square = [(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)]
    ball = [(np.sin(angle), -np.cos(angle)) for angle in np.linspace(0.0, np.pi, 65)]
    rod = solids.tube([(0, 0, z) for z in np.linspace(0.0, 3.0, 5)], [0.5] * 5, 256)
    cases = {
        "box": (solids.box((1.0, 2.0, 3.0)), 6.0),
        "bevelled box": (solids.box((1.0, 2.0, 3.0), 1e-4), 6.0),
        "ring": (solids.lathe(square, 256), np.pi * (4.0 - 1.0)),
        "ball": (solids.lathe(ball, 256, closed=False), 4.0 / 3.0 * np.pi),
        "rod": (rod, 0.25 * np.pi * 3.0),
        "mirrored rod": (solids.mirror(rod, 0), 0.25 * np.pi * 3.0),
    }
    for name, (corners, expected) in cases.items():
        # 256 chords of a circle miss 1e-4 of its area, 64 arcs of the ball's profile 1e-3.
        assert volume(corners) == pytest.approx(expected, rel=2e-3), name
        # Every edge is used once each way: the solid is closed.
        keys = np.round(corners, 9) + 0.0
        _, indices = np.unique(keys.reshape(-1, 3), axis=0, return_inverse=True)
        edges = indices.reshape(-1, 3)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        forwards = sorted(map(tuple, edges))
        assert forwards == sorted((b, a) for a, b in forwards), name


def test_every_part_of_the_cart_is_closed(generator: Callable[[str], ModuleType]) -> None:
    cart = generator("cart")
    for part in [*cart.planks(), *cart.shafts(12), *cart.bolts(12), *cart.wheel(0.4, 24, 8, 6)]:
        # The directed areas of a closed surface add up to nothing.
        total = np.abs(doubled_areas(part).sum(axis=0)).max()
        assert total < 1e-12 * len(part), total
        assert volume(part) > 0.0


@pytest.mark.parametrize("name", CHEAP)
def test_the_generated_files_are_what_the_generator_writes(name: str, tmp_path: Path) -> None:
    scene = generated_scenes()[name]
    for made, kept in zip(write_files(scene, tmp_path), scene.paths, strict=True):
        advice = f"{kept} is out of date: python -m harness generate --scene {name}"
        assert made.read_bytes() == kept.read_bytes(), advice


def test_the_table_names_every_generated_scene_and_only_such() -> None:
    for scene in generated_scenes().values():
        assert (scene.folder / "scene.xml").is_file(), scene.name
        text = (scene.folder / "scene.xml").read_text()
        assert all(file in text for file in scene.files), scene.name
        assert (SCENES / "generators" / f"{scene.generator}.py").is_file(), scene.name


def test_what_is_generated_is_not_committed() -> None:
    paths = [str(path) for scene in generated_scenes().values() for path in scene.paths]
    command = ["git", "check-ignore", "--", *paths]
    ignored = subprocess.run(
        command, cwd=SCENES, capture_output=True, text=True, check=False
    ).stdout.splitlines()
    assert sorted(ignored) == sorted(paths)


@pytest.fixture
def shipped_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The scenes menger-1 and sphereflake elsewhere, without their generated files."""
    for name in ("menger-1", "sphereflake"):
        (tmp_path / name).mkdir()
        shutil.copy(SCENES / name / "scene.xml", tmp_path / name)
    table = tmp_path / "generated.yaml"
    written = yaml.safe_load((SCENES / "generators" / "generated.yaml").read_text())
    kept = {name: written[name] for name in ("menger-1", "sphereflake")}
    table.write_text(yaml.safe_dump(kept))
    monkeypatch.setattr(generated, "SCENES", tmp_path)
    monkeypatch.setattr(generated, "TABLE", table)
    generated_scenes.cache_clear()
    yield tmp_path
    generated_scenes.cache_clear()


@pytest.mark.parametrize(
    ("name", "file"), [("menger-1", "assets/menger-1.ply"), ("sphereflake", "assets/flake.xml")]
)
def test_a_missing_generated_file_is_named_with_the_command_that_makes_it(
    name: str, file: str, shipped_copy: Path
) -> None:
    folder = shipped_copy / name
    with pytest.raises(SceneError) as caught:
        load_scene(folder)
    command = f"python -m harness generate --scene {name}"
    assert str(caught.value) == f'{folder}: file not found: "{file}" (made by: {command})'


def test_files_yet_to_be_generated_are_inputs_of_their_scene(shipped_copy: Path) -> None:
    listed = files_of_scene(shipped_copy / "menger-1")
    expected = [shipped_copy / "menger-1" / file for file in ("assets/menger-1.ply", "scene.xml")]
    assert listed == [str(path) for path in expected]


def test_nothing_is_generated_in_a_scene_outside_of_the_table(tmp_path: Path) -> None:
    assert generated_in(tmp_path) is None
    assert generated_in(SCENES / "hard") is None
