"""`./bench features`: the whole list, of accepted and of refused scenes."""

from __future__ import annotations

from pathlib import Path

import mitsuba as mi
import pytest
from guest_scenes import LAMP, sensor, write

import harness
from harness.__main__ import main
from harness.describe import describe_scene, format_description
from harness.scene import active_variant


def cornell_box() -> dict[str, object]:
    with active_variant("scalar_rgb"):
        return mi.cornell_box()


def test_an_accepted_scene_is_described_with_its_requirements_and_models(tmp_path: Path):
    description = describe_scene(write(tmp_path, LAMP))
    assert description.accepted(), description
    assert description.missing == ()
    assert description.models == {"path": "", "haste": "", "whitted": ""}
    assert [(use.kind, use.name, use.id, use.status) for use in description.plugins] == [
        ("Shape", "sphere", "lamp", "supported"),
        ("Emitter", "area", "", "supported"),
        ("Sensor", "perspective", "eye", "supported"),
        ("Film", "hdrfilm", "plane", "supported"),
    ]
    text = format_description(description)
    assert "  requires   spheres, sphere_lights\n" in text, text
    assert (
        "  contains   0 triangles, 1 sphere, 1 light, 1 shape, 1 material\n"
        "  settings   path; 64 x 64 pixels, max_depth 8, max_layers 4\n"
        "  path       rendered\n  haste      possible\n" in text
    ), text
    assert text.endswith("  can be rendered"), text


def test_the_list_is_whole_where_the_scene_is_refused(tmp_path: Path):
    body = (
        '<integrator type="volpath" id="fog"/>\n'
        '<shape type="cylinder" id="pipe"><bsdf type="roughplastic"/></shape>\n'
        '<shape type="ply" id="lost"><string name="filename" value="lost.ply"/></shape>'
    )
    file = write(tmp_path, body)
    description = describe_scene(file)
    assert description.scene is None and not description.accepted()
    found = {(use.kind, use.name): use for use in description.plugins}
    statuses = {key: use.status for key, use in found.items()}
    assert statuses == {
        ("Integrator", "volpath"): "ignored",
        ("Shape", "cylinder"): "missing",
        ("BSDF", "roughplastic"): "missing",
        ("Shape", "ply"): "supported",
        ("Sensor", "perspective"): "supported",
        ("Film", "hdrfilm"): "supported",
    }
    assert found["BSDF", "roughplastic"].place == f"{file} (line 3, col 35)"
    assert found["Integrator", "volpath"].note == (
        "replaced by the integrator of the lighting model, with the depths of settings.yaml"
    )
    text = format_description(description)
    assert (
        '  missing    shape "cylinder": unsupported shape; supported are sphere, rectangle, cube, '
        'disk, ply, obj\n             "pipe" at line 3, col 2\n' in text
    ), text
    lost = f'  wrong      shape "ply" (id "lost") at {file} (line 4, col 2): file not found'
    assert f'{lost}: "lost.ply"\n' in text, text
    assert text.endswith('  cannot be rendered: missing bsdf "roughplastic", shape "cylinder"'), (
        text
    )


def test_what_is_wrong_without_a_missing_plugin_is_printed(tmp_path: Path):
    body = LAMP.replace("</shape>", '<bsdf type="conductor"/><bsdf type="diffuse"/></shape>')
    description = describe_scene(write(tmp_path, body))
    assert not description.missing and not description.accepted()
    text = format_description(description)
    assert "  wrong      shape" in text and "at most one BSDF" in text, text
    assert text.endswith("  cannot be rendered"), text


def test_malformed_xml_is_described_by_its_error(tmp_path: Path):
    file = tmp_path / "scene.xml"
    file.write_text('<scene version="3.0.0">\n<shape>\n')
    description = describe_scene(file)
    assert description.plugins == ()
    assert len(description.problems) == 1, description.problems
    assert "line 3" in description.problems[0] or "line 2" in description.problems[0]


def test_a_model_that_the_settings_name_and_the_scene_forbids_is_a_refusal(tmp_path: Path):
    sky = '<shape type="sphere"/><emitter type="constant"/>'
    file = write(tmp_path, sky)
    (tmp_path / "settings.yaml").write_text("models: [path, haste]\n")
    description = describe_scene(file)
    assert not description.accepted()
    assert description.accepted(["path"])
    assert description.models["haste"].startswith("an environment has no meaning in the model")
    text = format_description(description)
    assert "  haste      not possible: an environment" in text, text


def test_many_places_are_shortened_unless_all_are_asked_for_or_missing(tmp_path: Path):
    description = describe_scene(write(tmp_path, "\n".join([LAMP.replace(' id="lamp"', "")] * 9)))
    short, whole = (format_description(description, every_place=every) for every in (False, True))
    assert '  supported  shape "sphere", 9 times\n' in short, short
    assert "and 5 more" in short and "more" not in whole, (short, whole)
    cylinders = "\n".join(['<shape type="cylinder"/>'] * 9)
    missing = format_description(describe_scene(write(tmp_path, cylinders)))
    assert "line 10, col 2" in missing and "more" not in missing, missing


def test_a_dictionary_is_described_by_its_keys():
    scene = cornell_box()
    assert describe_scene(scene).accepted()
    scene["white"] = {"type": "no-such-plugin"}
    description = describe_scene(scene)
    assert [(use.name, use.note) for use in description.missing] == [
        ("no-such-plugin", "there is no such plugin")
    ]
    assert 'at "white"' in format_description(description), format_description(description)


def test_a_scene_is_loaded_from_a_path_and_from_a_dictionary(tmp_path: Path):
    file = write(tmp_path, LAMP)
    assert harness.load_scene(file).name == tmp_path.name
    assert harness.load_scene(str(file)).lights == harness.load_scene(file).lights
    assert len(harness.load_scene(cornell_box()).triangles) == 36


def test_the_command_exits_with_1_if_anything_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    good = write(tmp_path, LAMP, name="good.xml")
    bad = write(tmp_path, '<shape type="cylinder"/>', sensor(), name="bad.xml")
    assert main(["features", str(good), "cornell-box"]) == 0
    out = capsys.readouterr().out
    assert "good.xml\n  requires" in out and "cornell-box\n  requires" in out, out
    assert main(["features", str(bad), str(good)]) == 1
    out = capsys.readouterr().out
    assert "good.xml" in out, "the list must go on after a scene that is refused"
    assert main(["features", str(tmp_path / "nowhere.xml")]) == 1
    assert "no such scene" in capsys.readouterr().out
