"""The copy of a scene with what is missing here replaced."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from guest_scenes import CORNERS, LAMP, PLY, face, write

from harness.__main__ import main
from harness.retarget import retarget
from harness.scene import SceneError, load_scene

RADIO = (
    '<!-- a comment --><bsdf type="radio" id="concrete"><string name="type" value="concrete"/>'
    '</bsdf>\n<shape type="ply" id="mesh"><string name="filename" value="meshes/mesh.ply"/>'
    '<ref id="concrete"/></shape>'
)


@pytest.fixture
def radio(tmp_path: Path) -> Path:
    """A scene of one triangle, without light and camera, of a BSDF that there is not."""
    folder = tmp_path / "from"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "mesh.ply").write_bytes(PLY + CORNERS + face(0, 1, 2))
    return write(folder, RADIO, camera="", name="radio.xml")


def test_a_replaced_bsdf_keeps_its_id_and_loses_its_parameters(radio: Path, tmp_path: Path):
    target = tmp_path / "to" / "copy.xml"
    done = retarget(radio, target, replace_bsdf={"radio": "diffuse:0.6"}, emitter=2.0, camera=True)
    assert [line.removeprefix(f"{target}: ") for line in done[:3]] == [
        '1 BSDFs "radio" are "diffuse:0.6" now',
        f"1 references to files, relative to {target.parent}",
        "a constant environment of radiance 2",
    ]
    scene = load_scene(target)
    assert [(one.name, one.diffuse, one.twosided) for one in scene.materials] == [
        ("concrete", (0.6, 0.6, 0.6), False)
    ]
    assert scene.environment == (2.0, 2.0, 2.0)
    assert "a comment" in target.read_text(), "comments must stay"
    assert radio.read_text().count("radio") == 1, "the scene itself must stay as it is"
    assert sorted(path.name for path in target.parent.iterdir()) == ["copy.xml"]


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_the_added_camera_sees_every_vertex(radio: Path, tmp_path: Path, up: str):
    target = tmp_path / "copy.xml"
    retarget(radio, target, replace_bsdf={"radio": "twosided"}, emitter=1.0, camera=True, up=up)
    scene = load_scene(target)
    camera = scene.camera
    axes = np.array([camera.dx, camera.dy, camera.corner]).T
    for vertex in scene.vertices.astype(float):
        x, y, depth = np.linalg.solve(axes, vertex - camera.origin)
        assert depth > camera.near, (vertex, camera)
        assert 0.0 < x / depth < camera.width, (vertex, x / depth, camera)
        assert 0.0 < y / depth < camera.height, (vertex, y / depth, camera)
    upwards = np.eye(3)["xyz".index(up)]
    assert np.dot(camera.dy, upwards) < 0.0, "y runs down in a picture"
    assert scene.materials[0].twosided


def test_what_is_there_already_is_not_added(tmp_path: Path):
    file = write(tmp_path, LAMP)
    target = tmp_path / "copy.xml"
    done = retarget(file, target, replace_bsdf={}, emitter=1.0, camera=True)
    assert done == [
        f"{target}: no emitter added: the scene has 1",
        f"{target}: no camera added: the scene has 1",
    ]
    assert load_scene(target).lights == load_scene(file).lights


@pytest.mark.parametrize(
    ("replacements", "message"),
    [
        ({"plastic": "diffuse"}, 'no BSDF of the type "plastic" is in it'),
        (
            {"radio": "plastic"},
            'BSDF "plastic" is not supported; phong, diffuse, conductor, dielectric, twosided are',
        ),
        ({"radio": "diffuse:2"}, '"diffuse:2" is not of the form diffuse:0.8'),
        ({"radio": "conductor:0.5"}, '"conductor:0.5" is not of the form diffuse:0.8'),
    ],
)
def test_an_impossible_replacement_is_refused(
    radio: Path, tmp_path: Path, replacements: dict[str, str], message: str
):
    with pytest.raises(SceneError) as caught:
        retarget(radio, tmp_path / "copy.xml", replace_bsdf=replacements)
    assert str(caught.value) == f"{radio}: {message}"
    assert not (tmp_path / "copy.xml").exists()


def test_a_copy_that_would_still_be_refused_for_its_camera_says_why(radio: Path, tmp_path: Path):
    target = tmp_path / "copy.xml"
    with pytest.raises(SceneError, match='bsdf "radio" \\(id "concrete"\\) at the copy'):
        retarget(radio, target, replace_bsdf={}, camera=True)
    assert not list(tmp_path.glob("*copy*"))


def test_the_scene_itself_is_never_overwritten(radio: Path):
    before = radio.read_bytes()
    with pytest.raises(SceneError, match="must not replace the scene itself"):
        retarget(radio, radio, replace_bsdf={"radio": "diffuse"})
    assert radio.read_bytes() == before


def test_the_command_prints_what_it_did(
    radio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    target = tmp_path / "copy.xml"
    arguments = ["retarget", str(radio), str(target), "--replace-bsdf", "radio=diffuse"]
    assert main([*arguments, "--add-emitter", "--add-camera"]) == 0
    assert "a constant environment of radiance 1" in capsys.readouterr().out
    assert main(["features", str(target)]) == 0
    assert main(["retarget", str(tmp_path / "no.xml"), str(target)]) == 1
    assert "no such scene" in capsys.readouterr().err
