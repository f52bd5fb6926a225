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
        ({"rays": {"count": {"cpu": 0}}}, r"rays\.count\.cpu: 0 is less than"),
        ({"rays": {"traversals": ["octree"]}}, r"rays\.traversals\.0: 'octree' is not one of"),
        ({"rays": {"classes": ["bounce"]}}, r"rays\.classes\.0: 'bounce' is not one of"),
        ({"rays": {"scenes": ["teapot-nowhere"]}}, r"unknown scene 'teapot-nowhere'"),
        ({"study": {"engine_launches": {"depth_first": 8}}}, r"'depth_first' is not one of"),
        ({"study": {"largest": {"stream": 8}}}, r"study\.largest: 'stream' is not one of"),
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
        seeds={"spp": {"path": 16, "haste": 4, "whitted": 8}},
        truth={"spp": {"path": 128, "haste": 4, "whitted": 8}},
        scene_settings={"lamp": {"seeds_factor": {"path": 4}, "truth_factor": {"path": 0.5}}},
        tracer_settings={"embree": {"seeds_spp": {"path": 2}, "convergence": False}},
    )
    assert config.seeds_spp("lamp", "path", "embree") == 2
    assert config.seeds_spp("lamp", "path", "haste-cpu") == 64
    assert config.seeds_spp("lamp", "haste", "haste-cpu") == config["seeds"]["spp"]["haste"]
    assert config.truth_spp("lamp", "path") == 64
    assert config.converges("lamp", "path", "haste-cpu")
    assert not config.converges("lamp", "path", "embree")
    assert not config.converges("lamp", "whitted", "haste-cpu")


def test_every_count_of_the_convergence_gets_equal_samples_up_to_the_most_images(make_config: Any):
    config = make_config(
        convergence={"doublings": 5, "seeds": 2, "most_seeds": 16},
        scene_settings={"hard": {"convergence": {"seeds": 20}}},
    )
    assert [config.convergence_seeds("lamp", d) for d in range(6)] == [16, 16, 16, 8, 4, 2]
    assert [config.convergence_seeds("hard", d) for d in range(6)] == [20] * 6


def test_a_scene_with_a_known_answer_has_its_own_size_and_counts(
    make_config: Any, scene_path: Path
):
    counts = {"path": 1024, "haste": 256, "whitted": 16}
    changes: dict[str, Any] = {
        "answers": {"spp": counts},
        "scene_settings": {"lamp": {"truth_factor": {"path": 4}}},
        "tracer_settings": {"embree": {"seeds_spp": {"path": 2}}},
    }
    assert make_config(**changes).resolution("lamp") == (8, 8)
    assert make_config(**changes).seeds_spp("lamp", "path", "embree") == 2
    (scene_path.parent / "settings.yaml").write_text("answer: sphere_light\n")
    config = make_config(**changes)
    assert config.resolution("lamp") == (None, None)
    assert config.truth_spp("lamp", "path") == 4096
    assert config.truth_spp("lamp", "haste") == 256
    assert [config.seeds_spp("lamp", "path", name) for name in ("embree", "haste-cpu")] == [
        1024
    ] * 2


@pytest.mark.parametrize(
    "changes", [{"scene_settings": {"skul": {}}}, {"packets": {"scenes": ["skul"]}}]
)
def test_settings_of_a_scene_that_does_not_exist_are_refused(
    make_config: Any, changes: dict[str, Any]
):
    with pytest.raises(ConfigError, match=r"there is no scene 'skul'"):
        make_config(**changes)


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
