"""Turned knobs: each a setting of single renders, by images of the same seeds."""

import json
from typing import Any

import pytest

from harness.measure.config import Config, ConfigError
from harness.measure.job import measure_scene
from harness.measure.plan import knob_cases
from harness.scene import load_settings

KNOBS = {
    "scenes": ["lamp"],
    "tracers": ["embree"],
    "exact_depth": 32,
    "max_depth": [2],
    "rr_depth": [5],
    "clamp": [10],
    "film": ["float_atomic"],
    "seeds": 3,
    "spp": {"path": 2, "haste": 2},
}
OWN_DEPTH = 8
"""Of a scene without settings."""


def renders(fake: Any, tracer: str) -> list[str]:
    """Timed renders of turned knobs, in the order in which they were done."""
    return [
        line
        for line in fake.calls()
        if line.startswith(tracer) and ("max_depth=" in line or "samples=" in line)
    ]


def test_every_turn_is_warmed_up_and_rendered_once_before_any_is_again(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="Turning")
    measure_scene(make_config(knobs=KNOBS), "lamp", 2)
    turns = [
        "max_depth=32",
        "max_depth=2",
        f"max_depth={OWN_DEPTH}",
        "max_depth=32 rr_depth=5",
    ]
    warm = [f"T depth_first seed=0 spp=2 timed {turn}" for turn in turns]
    images = [
        f"T depth_first seed={seed} spp=2 timed {turn}" for seed in range(3) for turn in turns
    ]
    assert renders(fake, "T") == warm + images
    assert renders(fake, "A") == [], "haste-cpu is not among the tracers of the sweep"


def test_an_image_of_a_turn_is_kept_with_what_was_turned(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="Turning")
    config = make_config(knobs=KNOBS)
    measure_scene(config, "lamp", 2)
    folder = config.scene_dir("lamp") / "knobs" / "path" / "embree" / "max_depth-32_rr_depth-5"
    assert (folder / "seed_002.npy").is_file()
    record = json.loads((folder / "seed_002.json").read_text())
    assert record["case"] == {"max_depth": 32, "rr_depth": 5}, record
    assert (record["seed"], record["spp"]) == (2, 2), record


def test_what_a_tracer_cannot_turn_is_noted_with_the_reason(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="Turning")
    config = make_config(knobs=KNOBS)
    measure_scene(config, "lamp", 2)
    untaken = json.loads((config.scene_dir("lamp") / "untaken.json").read_text())
    assert [(row["case"], row["reason"]) for row in untaken] == [
        ({"max_depth": 32, "clamp": 10}, "embree has no choice of clamp"),
        ({"max_depth": 32, "film": "float_atomic"}, "embree has no choice of film"),
    ]


def test_a_second_run_turns_nothing_again_and_a_scene_left_out_loses_its_turns(
    fake: Any, make_config: Any
):
    fake(haste_cpu="SteadyA", embree="Turning")
    config = make_config(knobs=KNOBS)
    measure_scene(config, "lamp", 2)
    before = len(renders(fake, "T"))
    measure_scene(config, "lamp", 2)
    assert len(renders(fake, "T")) == before
    measure_scene(make_config(knobs=KNOBS | {"scenes": []}), "lamp", 2)
    assert list((config.scene_dir("lamp") / "knobs").rglob("*.npy")) == []


def test_sample_counts_of_haste_are_swept_each_with_each(make_config: Any, scene_path: Any):
    config: Config = make_config(knobs=KNOBS | {"light_samples": [1, 4], "ambient_samples": [1, 2]})
    settings = load_settings(scene_path)
    assert knob_cases(config, settings.render("haste")) == [
        {"ambient_samples": ambient, "light_samples": light}
        for light in (1, 4)
        for ambient in (1, 2)
    ]
    assert knob_cases(config, settings.render("whitted")) == []


def test_a_depth_that_is_the_exact_one_is_swept_once(make_config: Any, scene_path: Any):
    config = make_config(knobs=KNOBS | {"max_depth": [2, 8, 32]})
    depths = [
        case["max_depth"]
        for case in knob_cases(config, load_settings(scene_path).render("path"))
        if len(case) == 1
    ]
    assert depths == [32, 2, 8]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scenes": ["nowhere"]}, "knobs.scenes: there is no scene 'nowhere'"),
        ({"seeds": 2}, "knobs.seeds: 2 is less than the minimum of 3"),
        ({"clamp": [0]}, r"knobs.clamp.0: 0 is less than or equal to the minimum of 0"),
    ],
)
def test_a_sweep_that_makes_no_sense_is_refused_by_its_name(
    make_config: Any, changes: dict[str, Any], message: str
):
    with pytest.raises(ConfigError, match=message):
        make_config(knobs=KNOBS | changes)
