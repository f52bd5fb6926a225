"""Materials, lights, references and hashes of imported scenes."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest

from harness.scene import Scene, load_scene

SPHERE = '<shape type="sphere" id="ball">{}</shape>'
PHONG: dict[str, Any] = {
    "type": "phong",
    "diffuse_reflectance": {"type": "rgb", "value": [0.1, 0.2, 0.3]},
    "exponent": 7.0,
}


def dictionary(**shapes: Any) -> dict[str, Any]:
    return {"type": "scene", "sensor": {"type": "perspective"}, **shapes}


@pytest.mark.parametrize(
    ("bsdf", "expected"),
    [
        ("", {"kind": "phong", "diffuse": (0.5,) * 3, "ambient": (0.5,) * 3}),
        (
            '<bsdf type="diffuse"><rgb name="reflectance" value=".1,.2,.3"/></bsdf>',
            {"diffuse": (0.1, 0.2, 0.3), "ambient": (0.1, 0.2, 0.3), "twosided": False},
        ),
        (
            '<bsdf type="phong"/>',
            {"diffuse": (0.5,) * 3, "specular": (0.0,) * 3, "exponent": 30.0, "ior": 1.5},
        ),
        (
            (
                '<bsdf type="phong"><rgb name="diffuse_reflectance" value=".1,.2,.3"/>'
                '<rgb name="specular_reflectance" value=".4"/><float name="exponent" value="9"/>'
                '<rgb name="ambient_reflectance" value=".6"/><float name="reflection" value=".1"/>'
                '<float name="transmission" value=".2"/><float name="int_ior" value="1.3"/></bsdf>'
            ),
            {
                "diffuse": (0.1, 0.2, 0.3),
                "specular": (0.4,) * 3,
                "ambient": (0.6,) * 3,
                "exponent": 9.0,
                "reflection": 0.1,
                "transmission": 0.2,
                "ior": 1.3,
            },
        ),
        (
            (
                '<bsdf type="twosided" id="both"><bsdf type="phong" id="inner">'
                '<rgb name="diffuse_reflectance" value=".7"/></bsdf></bsdf>'
            ),
            {"name": "both", "twosided": True, "diffuse": (0.7,) * 3, "ambient": (0.7,) * 3},
        ),
        (
            '<bsdf type="conductor"/>',
            {"kind": "phong", "reflection": 1.0, "diffuse": (0.0,) * 3, "ambient": (0.0,) * 3},
        ),
        ('<bsdf type="dielectric"/>', {"kind": "dielectric", "ior": np.float32(1.5046 / 1.000277)}),
        (
            (
                '<bsdf type="dielectric"><string name="int_ior" value="water"/>'
                '<float name="ext_ior" value="1"/></bsdf>'
            ),
            {"kind": "dielectric", "ior": np.float32(1.3330)},
        ),
        (
            '<emitter type="area"><rgb name="radiance" value="1,2,3"/></emitter>',
            {"kind": "phong", "diffuse": (0.0,) * 3, "ambient": (0.0,) * 3, "reflection": 0.0},
        ),
    ],
)
def test_each_bsdf_is_read_as_its_material(
    write_scene: Any, bsdf: str, expected: dict[str, Any]
) -> None:
    scene = load_scene(write_scene(SPHERE.format(bsdf)))
    material = scene.materials[scene.shapes[0].material]
    for name, value in expected.items():
        wanted = value if isinstance(value, str) else pytest.approx(value, rel=1e-6)
        assert getattr(material, name) == wanted, (name, material)


def test_references_defaults_nesting_and_includes_mean_what_they_mean_to_mitsuba(
    write_scene: Any, tmp_path: Path
) -> None:
    (tmp_path / "paint.xml").write_text(
        '<scene version="3.0.0"><bsdf type="diffuse" id="shared">'
        '<rgb name="reflectance" value="$grey"/></bsdf></scene>'
    )
    scene = load_scene(
        write_scene(
            '<default name="grey" value="0.25"/><include filename="paint.xml"/>'
            '<shape type="sphere" id="a"><ref id="shared"/></shape>'
            '<shape type="cube" id="b"><ref id="shared"/></shape>'
            '<shape type="cube" id="c"><bsdf type="diffuse" id="own"/></shape>'
        )
    )
    assert [shape.name for shape in scene.shapes] == ["a", "b", "c"]
    assert [material.name for material in scene.materials] == ["shared", "own"]
    assert [shape.material for shape in scene.shapes] == [0, 0, 1]
    assert scene.materials[0].diffuse == (0.25,) * 3
    assert "paint.xml (line 1" in scene.materials[0].location


def test_lights_point_to_their_shapes_and_back(write_scene: Any) -> None:
    emitter = '<emitter type="area"><rgb name="radiance" value="1,2,3"/></emitter>'
    scene = load_scene(
        write_scene(
            f'<shape type="cube"/>{SPHERE.format(emitter)}<shape type="cube">{emitter}</shape>'
        )
    )
    assert [light.shape for light in scene.lights] == [1, 2]
    assert [shape.light for shape in scene.shapes] == [-1, 0, 1]
    assert scene.lights[0].radiance == (1.0, 2.0, 3.0)
    assert scene.features.sphere_lights and scene.features.mesh_lights


def test_equal_shapes_are_not_merged(write_scene: Any) -> None:
    scene = load_scene(write_scene('<shape type="cube"/><shape type="cube"/>'))
    assert len(scene.shapes) == 2
    assert scene.triangle_shape.tolist() == [0] * 12 + [1] * 12
    assert int(scene.triangles.max()) == len(scene.vertices) - 1


def test_a_dictionary_gives_the_same_arrays_as_xml(write_scene: Any) -> None:
    text = load_scene(
        write_scene(
            '<shape type="cube" id="block"><bsdf type="phong">'
            '<rgb name="diffuse_reflectance" value=".1,.2,.3"/>'
            '<float name="exponent" value="7"/></bsdf></shape>'
        )
    )
    python = load_scene(dictionary(block={"type": "cube", "paint": PHONG}))
    assert np.array_equal(text.vertices, python.vertices)
    assert np.array_equal(text.triangles, python.triangles)
    assert python.materials[0].diffuse == pytest.approx(text.materials[0].diffuse)
    assert python.materials[0].exponent == text.materials[0].exponent == 7.0
    assert python.features == text.features


def test_mitsubas_own_cornell_box_is_accepted() -> None:
    mi.set_variant("scalar_rgb")
    scene = load_scene(mi.cornell_box(), 32, 32)
    assert scene.features.names() == ("triangles", "mesh_lights", "ambient", "diffuse")
    assert len(scene.triangles) == 36
    assert (scene.camera.width, scene.camera.height) == (32, 32)


def test_the_environment_is_read(write_scene: Any) -> None:
    sky = '<emitter type="constant"><rgb name="radiance" value="1,2,4"/></emitter>'
    assert load_scene(write_scene(SPHERE.format("") + sky)).environment == (1.0, 2.0, 4.0)
    assert load_scene(write_scene(SPHERE.format(""))).environment is None


def test_an_integrator_that_no_scalar_variant_knows_does_not_matter(write_scene: Any) -> None:
    scene = load_scene(write_scene('<integrator type="haste"/><shape type="cube"/>'))
    assert len(scene.shapes) == 1


def test_the_current_variant_is_left_alone(write_scene: Any) -> None:
    mi.set_variant("scalar_rgb")
    load_scene(write_scene('<shape type="cube"/>'))
    assert mi.variant() == "scalar_rgb"


def test_importing_the_package_does_not_import_mitsuba() -> None:
    code = "import sys, harness.scene; sys.exit('mitsuba' in sys.modules)"
    root = Path(__file__).parents[3]
    assert subprocess.run([sys.executable, "-c", code], cwd=root, check=False).returncode == 0


def test_the_hash_follows_content_and_not_place(tmp_path: Path) -> None:
    source = Path(__file__).parents[3] / "scenes" / "cornell-box"
    copy = tmp_path / "elsewhere"
    shutil.copytree(source, copy)
    first = load_scene(source, 8, 8)
    assert load_scene(copy, 16, 16).sha256 == first.sha256
    asset = copy / "assets" / "light.ply"
    content = bytearray(asset.read_bytes())
    content[content.index(b"end_header") + 12] ^= 1
    asset.write_bytes(content)
    assert load_scene(copy, 8, 8).sha256 != first.sha256


def test_the_hash_of_a_dictionary_follows_its_values() -> None:
    def sphere(radius: float) -> Scene:
        return load_scene(dictionary(ball={"type": "sphere", "radius": radius}))

    assert sphere(1.0).sha256 == sphere(1.0).sha256
    assert sphere(1.0).sha256 != sphere(1.5).sha256


def shifted(offset: float) -> dict[str, Any]:
    mi.set_variant("scalar_rgb")
    move = mi.ScalarTransform4d().translate([offset, -offset, 2.0 * offset])
    turn = mi.ScalarTransform4d().rotate([1, 2, 3], 40.0).scale([0.5, 0.7, 0.3])
    return dictionary(
        block={"type": "cube", "to_world": move @ turn},
        ball={"type": "sphere", "radius": 0.3, "to_world": move},
        sensor={
            "type": "perspective",
            "to_world": move @ mi.ScalarTransform4d().translate([0, 0, -4]),
        },
    )


def test_recentring_undoes_a_translation_of_ten_million() -> None:
    near, far = (load_scene(shifted(offset), recentre=True) for offset in (0.0, 1e7))
    # A double near 1e7 is rounded by at most 2^-30; the rest is one rounding to float32 near 1.
    tolerance = 2.0**-28 + 2.0**-23
    assert np.abs(near.vertices - far.vertices).max() < tolerance
    assert np.abs(near.spheres - far.spheres).max() < tolerance
    assert np.abs(np.subtract(near.camera.origin, far.camera.origin)).max() < tolerance
    low, high = far.vertices.min(axis=0), far.vertices.max(axis=0)
    assert np.abs(low + high).max() < 0.5


def test_without_recentring_ten_million_ruins_the_geometry() -> None:
    near, far = (load_scene(shifted(offset), recentre=False) for offset in (0.0, 1e7))
    size = np.ptp(near.vertices, axis=0) - np.ptp(far.vertices, axis=0)
    assert np.abs(size).max() > 0.1
