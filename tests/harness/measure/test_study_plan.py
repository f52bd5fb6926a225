"""What the study of packets renders: enough rays for its launches, each case once."""

import math
from pathlib import Path
from typing import Any

import pytest
import yaml

from harness.measure.config import (
    DEFAULT_PRESET,
    ROOT,
    ConfigError,
    check_config,
    load_config,
)
from harness.measure.study_plan import QUEUES, StudyPlan, StudyRender
from harness.preflight import check_run
from harness.scene import load_settings

GPU = ("depth_first", "packets", "streams", "layers", "wavefront", "persistent")
PROCESSOR = ("depth_first", "packets", "layers")
SIZES = [2**k for k in range(8, 25)]


def settings(**changes: Any) -> dict[str, Any]:
    return {**yaml.safe_load(DEFAULT_PRESET.read_text())["study"], **changes}


def renders(engines: tuple[str, ...], rays: float = 6.0, **changes: Any) -> list[StudyRender]:
    return StudyPlan(settings(**changes), engines, SIZES, rays).renders()


@pytest.mark.parametrize("rays", [1.0, 6.3, 40.0])
def test_every_packet_size_has_rays_for_several_full_launches(rays: float):
    for one in renders(GPU, rays):
        if one.engine in QUEUES and one.repeats:
            found = one.samples * rays
            packet = int(str(one.case["packet"]))
            assert found >= 8 * packet, f"{one}: {found} rays"
            # No more than that, or than one sample a pixel: small packets are many launches.
            assert found <= max(8 * packet, 262144) + rays * one.width**2, f"{one}: {found} rays"


def test_a_launch_without_packets_is_an_image_of_so_many_samples():
    found = {one.samples for one in renders(GPU) if one.engine == "persistent"}
    assert found == set(SIZES)
    assert all(one.case["samples"] == one.samples for one in renders(GPU) if "samples" in one.case)


def test_every_engine_order_and_allocation_is_swept_in_every_size():
    cases = {
        (one.engine, one.case.get("order"), one.case.get("allocation")): 0
        for one in renders(GPU)
        if one.repeats
    }
    for one in renders(GPU):
        if one.repeats and "film" not in one.case:
            cases[one.engine, one.case.get("order"), one.case.get("allocation")] += 1
    assert set(cases.values()) == {len(SIZES)}, cases
    assert len(cases) == 4 + 2 + 4, cases


def test_no_render_is_planned_twice():
    keys = [one.key("subject") for one in renders(GPU)]
    assert len(keys) == len(set(keys))


def test_the_processor_has_no_allocations_films_or_joules():
    for one in renders(PROCESSOR, joules_seconds=1.0):
        assert not {"allocation", "film"} & set(one.case), one
        assert not one.with_joules, one


def test_the_film_of_floats_is_timed_as_often_as_that_of_integers():
    found = renders(GPU)
    for one in found:
        if one.case.get("film") == "float_atomic":
            case = {k: v for k, v in one.case.items() if k != "film"}
            (own,) = (r for r in found if r.engine == one.engine and r.case == case)
            assert (own.spp, own.width, own.repeats) == (one.spp, one.width, one.repeats)
    assert {one.engine for one in found if "film" in one.case} == set(GPU)


def test_an_engine_may_have_a_largest_launch():
    found = renders(GPU, largest={"streams": 4096})
    sizes = [int(str(one.case["packet"])) for one in found if one.engine == "streams"]
    assert max(sizes) == 4096


def test_an_engine_may_have_launches_of_its_own_number():
    found = renders(GPU, launches=32, engine_launches={"packets": 4})
    rays = {one.engine: 6.0 * one.samples for one in found if one.case.get("packet") == 1 << 20}
    assert 4 << 20 <= rays["packets"] < 5 << 20, rays
    assert rays["wavefront"] >= 32 << 20, rays


def test_layers_of_the_whole_image_are_set_against_packets_of_one_size():
    memory = [one for one in renders(GPU) if one.repeats == 0]
    assert {one.engine for one in memory} == {"layers", "packets"}
    for one in memory:
        expected = one.samples if one.engine == "layers" else 65536
        assert one.case["packet"] == expected, one


@pytest.mark.parametrize("preset", ["full", "gpu"])
def test_presets_sweep_three_scenes_in_every_power_of_two(preset: str):
    config = load_config(ROOT / "config" / f"{preset}.yaml")
    main = [("three-spheres", "haste"), ("skull", "haste"), ("mirror-glass", "haste")]
    main += [("mirror-glass", "whitted")]
    assert config.study_panels[:4] == main
    for name, model in main:
        assert config.study_sizes("haste-cuda", name, model) == SIZES
    for name, model in config.study_panels[4:]:
        assert config.study_sizes("haste-cuda", name, model) == [2**12, 2**16, 2**20]
    # A packet of the largest size can spawn all its children and stay below the queue's mark.
    children = 2 + config["study"]["ambient_samples"]
    assert config["study"]["queue_bytes"] >= 2 * children * max(SIZES) * 64
    assert math.log2(config["study"]["width"]).is_integer()


@pytest.mark.parametrize("preset", ["full", "gpu"])
def test_every_studied_scene_is_for_its_model(preset: str):
    config = load_config(ROOT / "config" / f"{preset}.yaml")
    for name, model in config.study_panels:
        assert model in load_settings(config.study_scenes[name]).models, (name, model)


def test_a_study_in_a_model_that_a_scene_is_not_for_is_refused(tmp_path: Path):
    values = load_config().values
    values["study"]["panels"] = {"balls": ["haste"]}
    values["results_dir"] = str(tmp_path)
    with pytest.raises(ConfigError, match="study: balls is a scene for path, not for haste"):
        check_run(check_config(values))


def test_the_quick_run_has_no_study():
    assert load_config().study_panels == []
