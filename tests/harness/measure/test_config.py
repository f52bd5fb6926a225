"""Settings: what is refused, and how presets are merged."""

from pathlib import Path
from typing import Any

import pytest

from harness.measure.config import ROOT, ConfigError, find_scene, load_config, merge


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"packets": {"sizes": [16, 0]}}, r"packets\.sizes\.1: 0 is less than"),
        ({"seeds": {"count": 1}}, r"seeds\.count: 1 is less than"),
        ({"seeds": {"spp": {"path": 0}}}, r"seeds\.spp\.path: 0 is less than"),
        ({"truth": {"batches": 15}}, r"truth\.batches: 15 is less than"),
        ({"tracers": ["povray"]}, r"tracers\.0: 'povray' is not one of"),
        ({"models": ["radiosity"]}, r"models\.0: 'radiosity' is not one of"),
        ({"scenes": ["teapot-nowhere"]}, r"unknown scene 'teapot-nowhere'"),
        ({"resolution": [64]}, r"resolution: "),
        ({"gate": {"delta": 0}}, r"gate\.delta: 0 is less than"),
        ({"sedes": {}}, r"'sedes' was unexpected"),
        ({"truth": {"seed": 5}}, r"truth\.seed: 5 is less than"),
        ({"miniature": False}, r"convergence\.doublings: 1 is less than 6"),
    ],
)
def test_an_impossible_setting_is_refused_by_its_name(
    make_config: Any, changes: dict[str, Any], message: str
):
    with pytest.raises(ConfigError, match=message) as error:
        make_config(**changes)
    assert len(str(error.value).splitlines()) == 1, str(error.value)


def test_settings_for_one_tracer_come_before_those_for_one_scene(make_config: Any):
    config = make_config(
        scene_settings={"lamp": {"seeds_spp": {"path": 64}, "truth_spp": {"path": 512}}},
        tracer_settings={"embree": {"seeds_spp": {"path": 2}, "convergence": False}},
    )
    assert config.seeds_spp("lamp", "path", "embree") == 2
    assert config.seeds_spp("lamp", "path", "haste-cpu") == 64
    assert config.seeds_spp("lamp", "haste", "haste-cpu") == config["seeds"]["spp"]["haste"]
    assert config.truth_spp("lamp", "path") == 512
    assert config.converges("haste-cpu")
    assert not config.converges("embree")


def test_mappings_merge_key_by_key_and_lists_whole():
    base = {"a": {"x": 1, "y": [1, 2]}, "b": 3}
    merged = merge(base, {"a": {"y": [5]}, "c": 4})
    assert merged == {"a": {"x": 1, "y": [5]}, "b": 3, "c": 4}
    assert base == {"a": {"x": 1, "y": [1, 2]}, "b": 3}


def test_a_scene_may_be_a_path_or_stand_alone(make_config: Any, scene_path: Path):
    assert find_scene(str(scene_path)) == scene_path.parent
    assert list(make_config(scenes=str(scene_path)).scenes) == ["lamp"]


@pytest.mark.parametrize("preset", ["quick", "check", "full", "gpu"])
def test_every_preset_is_valid(preset: str):
    config = load_config(ROOT / "config" / f"{preset}.yaml")
    assert config["preset"] == preset
    assert config["truth"]["batches"] >= 16
