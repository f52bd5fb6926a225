"""Everything that a scene may not contain is named, with its place."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.scene import SceneError, check_model, load_scene

BALL = '<shape type="sphere" id="ball">{}</shape>'
MESH = '<shape type="ply" id="mesh"><string name="filename" value="mesh.ply"/>{}</shape>'
LIGHT = '<emitter type="area"/>'


def transformed(inner: str) -> str:
    return BALL.format(f'<transform name="to_world">{inner}</transform>')


def phong(inner: str) -> str:
    return BALL.format(f'<bsdf type="phong" id="paint">{inner}</bsdf>')


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (BALL.format('<bsdf type="roughconductor" id="gold"/>'), "unsupported BSDF"),
        (
            BALL.format('<bsdf type="conductor"><string name="material" value="Au"/></bsdf>'),
            "mirror",
        ),
        (BALL.format('<bsdf type="conductor"><rgb name="eta" value=".1"/></bsdf>'), "mirror"),
        (
            BALL.format(
                '<bsdf type="conductor"><rgb name="specular_reflectance" value=".9"/></bsdf>'
            ),
            '"specular_reflectance" must be 1',
        ),
        (
            BALL.format(
                '<bsdf type="dielectric"><rgb name="specular_transmittance" value=".9"/></bsdf>'
            ),
            '"specular_transmittance" must be 1',
        ),
        (
            BALL.format('<bsdf type="dielectric"><string name="int_ior" value="mud"/></bsdf>'),
            "mud",
        ),
        (
            BALL.format(
                '<bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="diffuse"/></bsdf>'
            ),
            "around one BSDF, not 2",
        ),
        (BALL.format('<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>'), "that transmits"),
        (
            BALL.format(
                '<bsdf type="twosided"><bsdf type="phong">'
                '<float name="transmission" value=".5"/></bsdf></bsdf>'
            ),
            "that transmits",
        ),
        (
            BALL.format(
                '<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>'
            ),
            '"reflectance" is textured ("checkerboard")',
        ),
        (
            BALL.format(
                '<emitter type="area"><texture type="checkerboard" name="radiance"/></emitter>'
            ),
            '"radiance" is textured',
        ),
        (
            BALL.format('<emitter type="area"><rgb name="radiance" value="1,-1,1"/></emitter>'),
            "not negative",
        ),
        (
            BALL.format('<emitter type="area"><rgb name="radiance" value="1,nan,1"/></emitter>'),
            "finite",
        ),
        ('<emitter type="point"/>' + BALL.format(""), "unsupported emitter"),
        ('<shape type="cylinder"/>', "unsupported shape"),
        (
            '<shape type="ply" id="lost"><string name="filename" value="no.ply"/></shape>',
            '"no.ply"',
        ),
        ('<shape type="ply"/>', '"filename" is missing'),
        (transformed('<scale x="2"/>'), "scaled uniformly"),
        (transformed('<matrix value="1 .5 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/>'), "scaled uniformly"),
        (transformed('<translate x="nan"/>'), "finite"),
        (BALL.format('<float name="radius" value="-1"/>'), "radius"),
        (BALL.format('<float name="radius" value="0"/>' + LIGHT), "radius"),
        (phong('<float name="exponent" value="0"/>'), '"exponent" must be greater than 0'),
        (phong('<float name="exponent" value="-3"/>'), '"exponent" must be greater than 0'),
        (phong('<float name="exponent" value="nan"/>'), '"exponent" must be finite'),
        (phong('<float name="reflection" value="-.1"/>'), '"reflection" must be in [0, 1]'),
        (phong('<float name="transmission" value="nan"/>'), '"transmission" must be finite'),
        (phong('<float name="int_ior" value="0"/>'), '"int_ior" must be greater than 0'),
        (phong('<rgb name="diffuse_reflectance" value="-1"/>'), '"diffuse_reflectance"'),
        (phong('<rgb name="specular_reflectance" value="nan"/>'), '"specular_reflectance"'),
        (phong('<float name="shininess" value="1"/>'), 'unknown parameter "shininess"'),
        (BALL.format('<float name="colour" value="1"/>'), "colour"),
        ("", "no shapes"),
        (
            BALL.format("") + '<emitter type="constant"/><emitter type="constant"/>',
            "one environment",
        ),
        (
            BALL.format('<emitter type="area"><float name="sampling_weight" value="2"/></emitter>'),
            'unknown parameter "sampling_weight"',
        ),
        (BALL.format('<ref id="nothing"/>'), "nothing"),
        (BALL.format("<colour/>"), "colour"),
    ],
)
def test_what_is_not_supported_is_refused_by_name(
    write_scene: Any, body: str, message: str
) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene(write_scene(body))
    assert message in str(caught.value), str(caught.value)
    assert "scene.xml" in str(caught.value)


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        ("", "no sensor"),
        ('<sensor type="orthographic" id="eye"/>', "supported is perspective"),
        ('<sensor type="perspective"/><sensor type="perspective"/>', "exactly one sensor"),
        ('<sensor type="perspective"><film type="specfilm"/></sensor>', "supported is hdrfilm"),
        (
            (
                '<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/>'
                '<integer name="height" value="8"/>'
                '<integer name="crop_width" value="9"/></film></sensor>'
            ),
            "leaves the film",
        ),
        (
            (
                '<sensor type="perspective"><transform name="to_world"><scale value="2"/>'
                "</transform>"
                "</sensor>"
            ),
            "cale",
        ),
        ('<sensor type="perspective"><float name="far_clip" value="1.5"/></sensor>', "far_clip"),
        (
            (
                '<sensor type="perspective"><string name="fov_axis" value="z"/>'
                '<float name="fov" value="9"/></sensor>'
            ),
            "fov_axis",
        ),
    ],
)
def test_sensors_that_are_not_supported_are_refused(
    write_scene: Any, sensor: str, message: str
) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene(write_scene(BALL.format(""), sensor=sensor))
    assert message in str(caught.value), str(caught.value)


def test_a_crop_that_does_not_scale_to_whole_pixels_is_refused(write_scene: Any) -> None:
    film = "".join(
        f'<integer name="{name}" value="{value}"/>'
        for name, value in (("width", 40), ("height", 40), ("crop_width", 15), ("crop_height", 40))
    )
    file = write_scene(
        BALL.format(""),
        sensor=f'<sensor type="perspective"><film type="hdrfilm">{film}</film></sensor>',
    )
    assert load_scene(file, 30, 40).camera.width == 30
    with pytest.raises(SceneError, match="whole pixels"):
        load_scene(file, 20, 40)


@pytest.mark.parametrize(
    ("vertices", "faces", "extra", "message"),
    [
        ([[0, 0, 0], [math.nan, 0, 0], [0, 1, 0]], [[0, 1, 2]], "", "vertex 1 is"),
        ([[0, 0, 0], [math.inf, 0, 0], [0, 1, 0]], [[0, 1, 2]], LIGHT, "vertex 1 is"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], LIGHT, "a light of zero area"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 7]], "", "vertex 7"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [], "", "triangles"),
    ],
)
def test_broken_meshes_are_refused(
    write_scene: Any, write_ply: Any, vertices: Any, faces: Any, extra: str, message: str
) -> None:
    file = write_scene(MESH.format('<boolean name="face_normals" value="true"/>' + extra))
    write_ply(file.parent / "mesh.ply", vertices, np.reshape(faces, (-1, 3)))
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    assert message in str(caught.value), str(caught.value)
    assert "scene.xml (line 2" in str(caught.value)


@pytest.mark.parametrize("normal", [[0, 0, 0], [math.nan, 0, 1]])
def test_normals_without_direction_are_refused(
    write_scene: Any, write_ply: Any, normal: list[float]
) -> None:
    file = write_scene(MESH.format(""))
    normals = [[0, 0, 1], [0, 0, 1], normal]
    write_ply(file.parent / "mesh.ply", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], normals)
    with pytest.raises(SceneError, match="the normal of vertex 2 is zero or not finite"):
        load_scene(file)


def test_an_infinite_vertex_in_an_obj_file_is_refused(write_scene: Any) -> None:
    file = write_scene(MESH.format("").replace("ply", "obj"))
    (file.parent / "mesh.obj").write_text("v 0 0 0\nv 1e60 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(SceneError, match=r"finite|invalid vertex"):
        load_scene(file)


def test_a_degenerate_triangle_in_a_light_of_some_area_is_dropped(
    write_scene: Any, write_ply: Any
) -> None:
    file = write_scene(MESH.format('<boolean name="face_normals" value="true"/>' + LIGHT))
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]]
    write_ply(file.parent / "mesh.ply", vertices, [[0, 1, 2], [0, 1, 3]])
    scene = load_scene(file)
    assert scene.triangles.tolist() == [[0, 1, 2]]
    assert scene.dropped_triangles[0].tolist() == [1]


def test_a_mirrored_mesh_with_normals_is_refused(write_scene: Any) -> None:
    body = (
        '<shape type="rectangle" id="floor"><transform name="to_world"><scale x="-1"/></transform>'
        "</shape>"
    )
    with pytest.raises(SceneError, match="contradicts its vertex normals"):
        load_scene(write_scene(body))


def test_one_error_names_every_problem_with_its_place(write_scene: Any) -> None:
    file = write_scene(
        '<shape type="cylinder" id="pipe"/>\n<emitter type="point" id="bulb"/>\n'
        + phong('<float name="exponent" value="0"/><float name="gloss" value="1"/>')
    )
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    assert len(caught.value.problems) == 4
    for expected in (
        f'shape "cylinder" (id "pipe") at {file} (line 2',
        f'emitter "point" (id "bulb") at {file} (line 3',
        f'bsdf "phong" (id "paint") at {file} (line 4',
        '"gloss"',
    ):
        assert expected in str(caught.value), str(caught.value)


def test_a_dictionary_is_refused_with_the_path_of_its_keys() -> None:
    scene = {
        "type": "scene",
        "sensor": {"type": "perspective"},
        "ball": {"type": "sphere", "paint": {"type": "roughplastic"}},
    }
    with pytest.raises(SceneError, match=r'"roughplastic".*"ball\.paint"'):
        load_scene(scene)


@pytest.mark.parametrize("name", ["nowhere", "nowhere.xml"])
def test_a_missing_scene_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(SceneError, match="nowhere"):
        load_scene(tmp_path / name)


def test_a_root_that_is_no_scene_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "paint.xml"
    file.write_text('<bsdf version="3.0.0" type="diffuse"/>')
    with pytest.raises(SceneError, match="the root must be a scene"):
        load_scene(file)


def test_broken_xml_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "broken.xml"
    file.write_text('<scene version="3.0.0"><shape type="cube">')
    with pytest.raises(SceneError, match=r"broken\.xml"):
        load_scene(file)


def test_path_refuses_materials_that_create_energy(write_scene: Any) -> None:
    mixed = (
        '<rgb name="diffuse_reflectance" value=".5,.2,.2"/>'
        '<rgb name="specular_reflectance" value="{},.1,.1"/><float name="reflection" value=".25"/>'
    )
    body = phong(mixed.format(0.26)).replace("</shape>", LIGHT + "</shape>")
    scene = load_scene(write_scene(body))
    check_model(scene, "haste")
    check_model(scene, "whitted")
    with pytest.raises(SceneError, match=r'"paint".* = 1\.01 > 1'):
        check_model(scene, "path")
    check_model(load_scene(write_scene(body.replace("0.26", "0.25"))), "path")


def test_the_papers_models_refuse_environments_and_darkness(write_scene: Any) -> None:
    sky = load_scene(write_scene(BALL.format(LIGHT) + '<emitter type="constant"/>'))
    dark = load_scene(write_scene(BALL.format("")))
    for model in ("haste", "whitted"):
        with pytest.raises(SceneError, match="environment"):
            check_model(sky, model)
        with pytest.raises(SceneError, match="no shape emits light"):
            check_model(dark, model)
    check_model(sky, "path")
    with pytest.raises(SceneError, match="nothing emits light"):
        check_model(dark, "path")
    with pytest.raises(SceneError, match="unknown model"):
        check_model(dark, "radiosity")
