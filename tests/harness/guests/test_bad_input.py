"""Bad input is one clear error, before anything is rendered: the table of docs/scenes.md."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import pytest
from guest_scenes import CORNERS, LAMP, PLY, face, sensor, write

from harness.__main__ import main
from harness.measure.config import ConfigError, load_config
from harness.preflight import check_run
from harness.scene import SceneError, check_model, load_scene, load_settings

SHAPES = "sphere, rectangle, cube, disk, ply, obj"
BSDFS = "phong, diffuse, conductor, dielectric, twosided"
MESH = (
    '<shape type="ply" id="mesh"><string name="filename" value="mesh.ply"/>'
    '<boolean name="face_normals" value="true"/>{}</shape>' + LAMP
)
AT_MESH = 'shape "ply" (id "mesh") at {file} (line 2, col 2): '
TOO_MANY = ", more than the 67108864 supported"
LIGHT = '<emitter type="area"/>'


def vertex(value: float) -> bytes:
    return struct.pack("<9f", 0, 0, 0, 1, value, 0, 0, 1, 0)


def refusal(file: Path, model: str = "path") -> str:
    """The error of importing a scene for a model."""
    with pytest.raises(SceneError) as caught:
        check_model(load_scene(file), model)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '<scene version="3.0.0">\n<shape type="sphere">\n</scene>\n',
            "Start-end tags mismatch (line 3, col 3)",
        ),
        ("", "No document element found (line 1, col 1)"),
    ],
)
def test_malformed_xml_is_refused_with_its_line(tmp_path: Path, text: str, message: str):
    file = tmp_path / "scene.xml"
    file.write_text(text)
    assert refusal(file) == f'{file}: Parsing of XML file "{file}" failed: {message}'


def test_a_missing_scene_file_is_named(tmp_path: Path):
    file = tmp_path / "nowhere.xml"
    assert refusal(file) == f"{file}: no such scene: {file} does not exist"


def test_everything_that_is_not_supported_is_named_at_once_with_ids_and_places(tmp_path: Path):
    body = (
        '<shape type="cylinder" id="pipe"><bsdf type="roughplastic" id="paint"/></shape>\n'
        '<emitter type="envmap" id="sky"/>\n'
        '<sensor type="thinlens" id="lens"><film type="specfilm" id="spectra"/></sensor>'
    )
    file = write(tmp_path, body, camera="")
    assert refusal(file) == (
        f"{file}: 5 problems\n"
        f'  - shape "cylinder" (id "pipe") at {file} (line 2, col 2): unsupported shape; supported '
        f"are {SHAPES}\n"
        f'  - emitter "envmap" (id "sky") at {file} (line 3, col 2): unsupported emitter; '
        "supported are area, constant\n"
        f'  - bsdf "roughplastic" (id "paint") at {file} (line 2, col 35): unsupported BSDF; '
        f"supported are {BSDFS}\n"
        f'  - sensor "thinlens" (id "lens") at {file} (line 4, col 2): unsupported sensor; '
        "supported is perspective\n"
        f'  - film "specfilm" (id "spectra") at {file} (line 4, col 36): unsupported film; '
        "supported is hdrfilm"
    )


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", '"mesh.ply" is empty'),
        (b"OFF\n3 1 0\n", '"mesh.ply" is not a PLY file'),
        (PLY[:90], '"mesh.ply" is truncated: it ends within its header'),
        (
            PLY + CORNERS[:-8],
            '"mesh.ply" is truncated: 2 of 3 records of "vertex" are there',
        ),
        (
            PLY + CORNERS + face(0, 1, 2)[:-4],
            '"mesh.ply" is truncated: 0 of 1 records of "face" are there',
        ),
        (
            PLY.replace(b"binary_little_endian", b"ascii") + b"0 0 0\n1 0 0\n0 1 0\n3 0 1\n",
            '"mesh.ply" is truncated: 0 of 1 records of "face" are there',
        ),
        (
            PLY + vertex(float("nan")) + face(0, 1, 2),
            '"mesh.ply" has a vertex that is not finite: vertex 1 is [1.0, nan, 0.0]',
        ),
        (
            PLY + vertex(float("inf")) + face(0, 1, 2),
            '"mesh.ply" has a vertex that is not finite: vertex 1 is [1.0, inf, 0.0]',
        ),
        (
            PLY + CORNERS + face(0, 1, 7),
            '"mesh.ply" has an index out of range: face 0 refers to vertex 7, and there are 3',
        ),
        (
            PLY + CORNERS + face(0, 1, -1),
            '"mesh.ply" has an index out of range: face 0 refers to vertex -1, and there are 3',
        ),
    ],
)
def test_a_broken_mesh_file_is_named_with_what_is_wrong(tmp_path: Path, data: bytes, message: str):
    (tmp_path / "mesh.ply").write_bytes(data)
    file = write(tmp_path, MESH.format(""))
    assert refusal(file) == f"{file}: {AT_MESH.format(file=file)}{message}"


def test_all_broken_files_of_a_scene_are_named_at_once(tmp_path: Path):
    (tmp_path / "a.ply").write_bytes(PLY + CORNERS)
    (tmp_path / "b.obj").write_text("v 0 0 0\nv 1 0 zero\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "c.obj").write_text("v 0 0 0\nv 1e60 0 0\nv 0 1 0\nf 1 2 3\n")
    shape = '<shape type="{1}" id="{0}"><string name="filename" value="{0}.{1}"/></shape>'
    names = (("a", "ply"), ("b", "obj"), ("c", "obj"))
    file = write(tmp_path, "\n".join(shape.format(*name) for name in names))
    message = refusal(file)
    assert message.startswith(f"{file}: 3 problems\n"), message
    for line, (name, kind) in enumerate(names, start=2):
        assert f'shape "{kind}" (id "{name}") at {file} (line {line}, col 2): ' in message, message


def test_a_light_of_zero_area_is_refused(tmp_path: Path):
    (tmp_path / "mesh.ply").write_bytes(
        PLY + struct.pack("<9f", 0, 0, 0, 1, 0, 0, 2, 0, 0) + face(0, 1, 2)
    )
    file = write(tmp_path, MESH.format(LIGHT))
    assert refusal(file) == f"{file}: {AT_MESH.format(file=file)}a light of zero area"


def test_energy_above_1_is_refused_in_path_alone(tmp_path: Path):
    body = (
        '<bsdf type="phong" id="paint"><rgb name="diffuse_reflectance" value=".5,.2,.2"/>'
        '<float name="reflection" value=".75"/></bsdf>\n'
        f'<shape type="sphere"><ref id="paint"/>{LIGHT}</shape>'
    )
    file = write(tmp_path, body, name="bright.xml")
    check_model(load_scene(file), "haste")
    assert refusal(file) == (
        f'bright: material "paint" at {file} (line 2, col 2): diffuse + specular + reflection + '
        "transmission = 1.25 > 1, which the model path refuses"
    )


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ((0, 8), '"width" must be at least 1, not 0'),
        ((8, -3), '"height" must be at least 1, not -3'),
        (
            (1_000_000_000, 1),
            f"1000000000 x 1 are 1000000000 pixels{TOO_MANY}",
        ),
    ],
)
def test_a_film_of_no_or_too_many_pixels_is_refused(
    tmp_path: Path, size: tuple[int, int], message: str
):
    file = write(tmp_path, LAMP, sensor(*size))
    assert refusal(file) == f'{file}: film "hdrfilm" (id "plane") at {file} (line 3, col 127): ' + (
        message
    )


@pytest.mark.parametrize(
    ("model", "light", "message"),
    [
        ("path", "", "nothing emits light, so that a picture of the model path is black"),
        ("haste", "", "no shape emits light, so that a picture of the model haste is black"),
        (
            "path",
            '<emitter type="area"><rgb name="radiance" value="0"/></emitter>',
            "nothing emits light, so that a picture of the model path is black",
        ),
    ],
)
def test_a_scene_without_light_is_refused(tmp_path: Path, model: str, light: str, message: str):
    file = write(tmp_path, f'<shape type="sphere">{light}</shape>', name="dark.xml")
    assert refusal(file, model) == f"dark: {message}"


def test_a_missing_texture_file_is_named_beside_what_cannot_be_textured(tmp_path: Path):
    texture = (
        '<texture type="bitmap" name="reflectance"><string name="filename" value="wood.png"/>'
        "</texture>"
    )
    body = f'<shape type="sphere"><bsdf type="diffuse" id="wood">{texture}</bsdf></shape>{LAMP}'
    file = write(tmp_path, body)
    assert refusal(file) == (
        f"{file}: 2 problems\n"
        f'  - texture "bitmap" at {file} (line 2, col 54): file not found: "wood.png"\n'
        f'  - bsdf "diffuse" (id "wood") at {file} (line 2, col 23): "reflectance" is textured '
        '("bitmap"), not a constant colour'
    )


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ([0, 64], 'key "resolution.0": 0 is less than the minimum of 1'),
        ([64, 1_000_000_000], 'key "resolution.1": 1000000000 is greater than the maximum of 8192'),
    ],
)
def test_settings_of_a_scene_refuse_pictures_of_no_or_too_many_pixels(
    tmp_path: Path, size: list[int], message: str
):
    file = tmp_path / "settings.yaml"
    file.write_text(json.dumps({"resolution": size}))
    with pytest.raises(SceneError) as caught:
        load_settings(file)
    assert str(caught.value) == f"{file}: {message}"


def refused_run(folder: Path, **changes: Any) -> str:
    """The one line with which `python -m harness measure` refuses settings; nothing is written."""
    values = {"results_dir": str(folder / "results"), "scenes": [str(folder / "lamp.xml")]}
    file = folder / "run.yaml"
    file.write_text(json.dumps(values | changes))
    with pytest.raises((ConfigError, SceneError)) as caught:
        check_run(load_config(file))
    assert main(["measure", "--settings", str(file)]) == 1
    assert main(["truth", "--settings", str(file)]) == 1
    assert not (folder / "results").exists()
    return str(caught.value)


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    return write(tmp_path, LAMP, name="lamp.xml")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"resolution": [0, 64]}, "config: resolution.0: 0 is less than the minimum of 8"),
        (
            {"resolution": [40_000, 25_000]},
            f"config: resolution of lamp: 40000 x 25000 are 1000000000 pixels{TOO_MANY}",
        ),
        (
            {"seeds": {"spp": {"path": 0}}},
            "config: seeds.spp.path: 0 is less than the minimum of 1",
        ),
        (
            {"models": ["haste", "whitted"]},
            "config: models: lamp is a scene for path, and the run renders haste, whitted",
        ),
    ],
)
def test_an_impossible_run_is_refused_before_any_work(
    lamp: Path, changes: dict[str, Any], message: str
):
    assert refused_run(lamp.parent, **changes) == message


def test_two_scenes_of_one_name_are_refused(lamp: Path):
    other = lamp.parent / "other"
    other.mkdir()
    twin = write(other, LAMP, name="lamp.xml")
    message = refused_run(lamp.parent, scenes=[str(lamp), str(twin)])
    assert message == (
        f"config: scenes: {str(lamp)!r} and {str(twin)!r} have the same name, 'lamp'"
    )


def test_a_results_folder_that_cannot_be_written_is_refused_before_any_work(lamp: Path):
    folder = lamp / "results"
    assert refused_run(lamp.parent, results_dir=str(folder)) == (
        f"config: results_dir: {folder} cannot be written: {lamp}: Not a directory"
    )


def test_an_unknown_scene_is_refused_before_any_work(lamp: Path):
    message = refused_run(lamp.parent, scenes=["no-such-scene"])
    assert message.startswith("unknown scene 'no-such-scene': "), message


def test_a_refused_run_says_why_in_one_line(lamp: Path, capsys: pytest.CaptureFixture[str]):
    refused_run(lamp.parent, models=["haste"])
    line = "error: config: models: lamp is a scene for path, and the run renders haste"
    assert capsys.readouterr().err.splitlines() == [line, line]
