"""What cannot show is dropped and named, and the picture is the one without it, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

WriteScene = Callable[..., Path]
SPP, SEED = 16, 11
MODELS = ("path", "haste", "whitted")

LIGHT = """
<shape type="rectangle" id="lamp">
    <transform name="to_world">
        <scale value="0.4"/><rotate x="1" angle="180"/><translate z="2"/>
    </transform>
    <emitter type="area"><rgb name="radiance" value="9, 8, 7"/></emitter>
</shape>"""
FLOOR = """
<shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="3"/></transform>
    <bsdf type="phong"><rgb name="diffuse_reflectance" value="0.5, 0.4, 0.3"/></bsdf>
</shape>"""
BALL = """
<shape type="sphere" id="ball">
    <point name="center" x="0.8" y="0" z="0.5"/><float name="radius" value="0.5"/>{}
</shape>"""
BLACK = '<emitter type="area"><rgb name="radiance" value="0, 0, 0"/></emitter>'
NOTHING = """<bsdf type="phong">
    <rgb name="diffuse_reflectance" value="0, 0, 0"/></bsdf>"""
SHINY = """<bsdf type="phong">
    <rgb name="diffuse_reflectance" value="0.3, 0.4, 0.5"/>{}</bsdf>"""
TWO_SIDED = f'<bsdf type="twosided">{NOTHING}</bsdf>'
MESH = '<shape type="ply" id="mesh"><string name="filename" value="{}.ply"/>{}</shape>'
GREY = SHINY.format("")
GLOW = '<emitter type="area"><rgb name="radiance" value="2, 3, 4"/></emitter>'

CORNERS = np.array(
    [[-1, -0.5, 0.2], [0, -0.5, 0.3], [0, 0.5, 0.9], [-1, 0.5, 0.8], [-0.5, 0, 1.3]], np.float32
)
FACES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], np.uint32)
NORMALS = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1], [0, 0, 1]], np.float32)
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
# Without area: a corner twice, all three the same, and three in a row.
ROW = np.array([[-1, -0.5, 0.2], [-0.5, -0.5, 0.25], [0, -0.5, 0.3]], np.float32)
DEGENERATE = np.array([[0, 0, 2], [3, 3, 3], [2, 4, 2]], np.uint32)

BODIES = {
    "unused material": (
        BALL.format(GREY),
        f'<bsdf type="dielectric" id="spare"/>{BALL.format(GREY)}',
        "1 unused material of bsdf",
    ),
    "black light of a sphere": (
        BALL.format(NOTHING),
        BALL.format(BLACK),
        "1 black light of shape",
    ),
    "black light of a mesh": (
        MESH.format("clean", NOTHING),
        MESH.format("clean", BLACK),
        "1 black light of shape",
    ),
    "black environment": (
        BALL.format(GREY),
        BALL.format(GREY) + '<emitter type="constant"><rgb name="radiance" value="0"/></emitter>',
        "1 black environment of emitter",
    ),
    "specular lobe": (
        BALL.format(GREY),
        BALL.format(
            SHINY.format(
                '<rgb name="specular_reflectance" value="0"/><float name="exponent" value="9"/>'
            )
        ),
        "1 specular lobe without weight of bsdf",
    ),
    "mirror and refraction": (
        BALL.format(GREY),
        BALL.format(
            SHINY.format(
                '<float name="reflection" value="0"/><float name="transmission" value="0"/>'
            )
        ),
        "1 refraction lobe without weight of bsdf",
    ),
    "second side": (
        BALL.format(NOTHING),
        BALL.format(TWO_SIDED),
        "1 black second side of bsdf",
    ),
    "degenerate triangles": (
        MESH.format("clean", GREY),
        MESH.format("degenerate", GREY),
        "3 degenerate triangles of shape",
    ),
    "degenerate triangles of a light": (
        MESH.format("clean", GLOW),
        MESH.format("degenerate", GLOW),
        "3 degenerate triangles of shape",
    ),
    "duplicate vertices": (
        MESH.format("smooth", GREY),
        MESH.format("duplicated", GREY),
        "7 duplicate or unused vertices of shape",
    ),
    "unused vertices": (
        MESH.format("clean", GREY),
        MESH.format("unused", GREY),
        "2 duplicate or unused vertices of shape",
    ),
}


@pytest.fixture
def meshes(tmp_path: Path, write_ply: Callable[..., None]) -> None:
    """The meshes of the scenes, clean and with dead weight."""
    write_ply(tmp_path / "clean.ply", CORNERS, FACES)
    mixed = np.concatenate([DEGENERATE[:1], FACES[:2], DEGENERATE[1:], FACES[2:]])
    write_ply(tmp_path / "degenerate.ply", CORNERS, mixed)
    write_ply(tmp_path / "smooth.ply", CORNERS, FACES, NORMALS)
    every = FACES.ravel()
    own = np.arange(12, dtype=np.uint32).reshape(-1, 3)
    write_ply(tmp_path / "duplicated.ply", CORNERS[every], own, NORMALS[every])
    more = np.concatenate([CORNERS, [[9, 9, 9], [-9, 0, 0]]]).astype(np.float32)
    write_ply(tmp_path / "unused.ply", more, FACES)


def films(file: Path) -> dict[str, str]:
    """The film's hash in each model."""
    import haste_cuda

    scene = to_core(load_scene(file), 1)
    found = {}
    for model in MODELS:
        settings = to_core_settings(load_settings({}).render(model, 16, 12))
        answer = haste_cuda.render_cpu(scene, model, settings, seed=SEED, samples=SPP, threads=1)
        found[model] = answer["film_sha256"]
    return found


def test_there_are_ten_planted_scenes() -> None:
    assert len(BODIES) >= 10


@pytest.mark.usefixtures("meshes")
@pytest.mark.parametrize("name", BODIES)
def test_planted_dead_weight_changes_no_bit_and_is_named(
    write_scene: WriteScene, name: str
) -> None:
    clean, planted, named = BODIES[name]
    before = write_scene(LIGHT + FLOOR + clean, name="clean.xml")
    after = write_scene(LIGHT + FLOOR + planted, name="planted.xml")
    assert films(before) == films(after)
    lines = [str(lost) for lost in load_scene(after).dropped]
    assert any(line.startswith(named) for line in lines), lines
    assert all("planted.xml (line" in line for line in lines), lines
    assert load_scene(before).features == load_scene(after).features


@pytest.mark.usefixtures("meshes")
@pytest.mark.parametrize("name", BODIES)
def test_a_scene_without_it_drops_nothing_of_the_kind(write_scene: WriteScene, name: str) -> None:
    clean, _, named = BODIES[name]
    scene = load_scene(write_scene(LIGHT + FLOOR + clean))
    assert not [lost for lost in scene.dropped if str(lost).startswith(named)]


@pytest.mark.parametrize(
    ("vertices", "normals", "kept"),
    [
        (CORNERS[[0, 1, 2, 0, 2, 3]], None, 4),
        (CORNERS[[0, 1, 2, 0, 2, 3]], NORMALS[[0, 1, 2, 0, 2, 3]], 4),
        # Both sides of a crease.
        (CORNERS[[0, 1, 2, 0, 2, 3]], NORMALS[[0, 1, 2, 4, 4, 3]], 6),
    ],
)
def test_only_vertices_that_are_equal_bit_for_bit_are_one(
    write_scene: WriteScene,
    write_ply: Callable[..., None],
    vertices: Any,
    normals: Any,
    kept: int,
) -> None:
    file = write_scene(LIGHT + MESH.format("own", GREY))
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.uint32)
    write_ply(file.parent / "own.ply", np.asarray(vertices, np.float32), faces, normals)
    scene = load_scene(file)
    mesh = next(shape for shape in scene.shapes if shape.name == "mesh")
    own = scene.triangles[mesh.first : mesh.first + mesh.count]
    assert len(np.unique(own)) == kept, own
    assert np.array_equal(scene.vertices[own], np.asarray(vertices, np.float32)[faces])
    if normals is not None and mesh.smooth:
        # Mitsuba makes them unit length again, which may round the last bit.
        assert np.allclose(scene.normals[own], normals[faces], rtol=0, atol=2.0**-23)


def test_a_dim_light_and_a_thin_triangle_stay(
    write_scene: WriteScene, write_ply: Callable[..., None]
) -> None:
    """Negative control: next to nothing is something."""
    dim = BLACK.replace("0, 0, 0", "0, 1e-30, 0")
    file = write_scene(LIGHT + BALL.format(dim) + MESH.format("thin", GREY))
    thin = np.array([[0, 0, 0], [1, 0, 0], [2, 1e-7, 0]], np.float32)
    write_ply(file.parent / "thin.ply", thin, np.array([[0, 1, 2]], np.uint32))
    scene = load_scene(file)
    assert len(scene.lights) == 2
    assert not scene.dropped_triangles
    assert not [lost for lost in scene.dropped if "light" in lost.what], scene.dropped


@pytest.mark.usefixtures("meshes")
def test_other_tracers_number_triangles_as_if_none_were_dropped(write_scene: WriteScene) -> None:
    """What Mitsuba calls triangle 5 of the mesh is the fourth that is left."""
    scene = load_scene(write_scene(FLOOR + MESH.format("degenerate", GREY)))
    (shape, gone), *others = scene.dropped_triangles.items()
    assert not others
    assert scene.shapes[shape].name == "mesh"
    assert gone.tolist() == [0, 3, 4]
    left = [number - int(np.searchsorted(gone, number)) for number in (1, 2, 5, 6)]
    assert left == [0, 1, 2, 3]
