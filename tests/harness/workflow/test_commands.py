"""The commands of ``python -m harness``."""

import json
from pathlib import Path

import pytest

from harness.__main__ import COMMANDS, main
from harness.measure.config import ROOT, load_config
from harness.measure.inputs import package_sources, scene_files, tracing_sources


def test_every_step_is_a_command():
    wanted = {"truth", "measure", "rays", "prices", "stability", "modes", "surfaces", "sweeps"}
    wanted |= {"study", "tables", "report", "check", "baseline", "compare", "features", "available"}
    wanted |= {"published"}
    assert set(COMMANDS) == wanted | {"generate", "thumbnails", "sheet"}


def test_a_bad_setting_is_one_line_and_exit_code_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "settings.json"
    file.write_text(json.dumps({"packets": {"sizes": [0]}}))
    assert main(["measure", "--settings", str(file)]) == 1
    error = capsys.readouterr().err
    assert error.splitlines() == ["error: config: packets.sizes.0: 0 is less than the minimum of 1"]


def test_a_scene_outside_the_settings_is_refused(capsys: pytest.CaptureFixture[str]):
    assert main(["truth", "--scene", "teapot-nowhere"]) == 1
    assert "--scene teapot-nowhere: the settings name cornell-box" in capsys.readouterr().err


def test_a_scene_outside_the_benchmark_of_rays_is_refused(capsys: pytest.CaptureFixture[str]):
    assert main(["rays", "--scene", "cornell-box"]) == 1
    assert "--scene cornell-box: the settings name skull, bunny" in capsys.readouterr().err


def test_features_prints_what_a_scene_requires(capsys: pytest.CaptureFixture[str]):
    assert main(["features", "--scene", "cornell-box"]) == 0
    assert "  requires   triangles, mesh_lights, ambient, diffuse\n" in capsys.readouterr().out


def test_inputs_name_the_sources_that_snakemake_cannot_see():
    names = tracing_sources()
    for name in ("harness/measure/job.py", "harness/scene/parse.py", "reference/mitsuba/phong.py"):
        assert name in names, names
    assert all((ROOT / name).is_file() for name in names), names
    assert package_sources("no/such/folder") == []


def test_inputs_of_a_scene_are_its_file_settings_and_meshes():
    names = scene_files(load_config())["skull"]
    assert "scenes/skull/scene.xml" in names, names
    assert "scenes/skull/settings.yaml" in names, names
    assert any(name.endswith(".ply") for name in names), names
    assert not any(name.endswith(".md") for name in names), names
