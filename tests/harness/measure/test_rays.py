"""The benchmark of rays as a job: what it writes, in which order it asks, and what it keeps."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.measure.config import Config
from harness.measure.rays import replay_scene
from harness.rays.classes import CLASSES
from harness.rays.generate import RaysError
from harness.rays.store import hash_file, read_rays
from harness.tracers.haste import HasteCpu

REASON = HasteCpu.unavailable()
pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")

COUNT = 512
BALL = """<shape type="sphere"><point name="center" x="2.5" y="0" z="0"/></shape>"""


@pytest.fixture
def make(make_config: Any, scene_path: Path) -> Callable[..., Config]:
    """Settings for few rays in a ball by a lamp; the keywords are those of the section `rays`."""
    scene_path.write_text(scene_path.read_text().replace("</scene>", f"{BALL}</scene>"))
    (scene_path.parent / "settings.yaml").write_text("models: [path]\nrays_inside: true\n")

    def config(tracers: list[str], **changes: Any) -> Config:
        rays = {
            "scenes": [str(scene_path)],
            "count": {"cpu": COUNT, "gpu": COUNT},
            "classes": ["camera", "diffuse1", "random_any"],
            "traversals": ["bvh2", "intersect1"],
            "repeats": 3,
            "warm_ups": 2,
            "sample": 128,
            "most": {},
        }
        return make_config(tracers=tracers, rays={**rays, **changes})

    return config


def replayed(config: Config) -> tuple[Path, dict[str, Any]]:
    """The folder, and the record of each class."""
    replay_scene(config, "lamp", 1)
    folder = config.ray_dir("lamp")
    return folder, {
        name: json.loads((folder / f"{name}.json").read_text())
        for name in config["rays"]["classes"]
    }


def test_every_tracer_is_given_the_rays_of_one_file(make: Callable[..., Config]):
    folder, records = replayed(make(["haste-cpu", "embree", "mitsuba-scalar"]))
    for name, record in records.items():
        assert (record["count"], record["any_hit"]) == (COUNT, CLASSES[name])
        rows = {(row["tracer"], row["precision"]): row for row in record["variants"]}
        ours, robust = rows["haste-cpu", "watertight"], rows["embree", "robust"]
        for row in (ours, robust):
            assert row["status"] == "ok" and row["rays"] == COUNT, row
            assert len(row["seconds"]) == 3 and min(row["seconds"]) > 0.0, row
            # Grazing rays are ambiguous, all others must be seen alike.
            assert row["wrong"]["count"] == 0 and row["wrong"]["rays"] > 100, (name, row)
            assert row["structure"]["size"] > 0.0 and row["peak_bytes"] > 2**20, row
        assert ours["differing"].keys() == {"embree", "mitsuba-scalar"}
        assert rows["embree", "fast"]["status"] == "ok", rows["embree", "fast"]
        # A call a ray sees as much and has no time.
        slow = rows["mitsuba-scalar", "native"]
        assert slow["status"] == "ok" and slow["seconds"] == [] and slow["wrong"]["rays"] > 100
    provenance = json.loads((folder / "provenance.json").read_text())
    assert provenance["rays"] == {"sha256": hash_file(folder / "rays.npz"), "count": COUNT}
    assert len(read_rays(folder / "rays.npz", "shuffled")) == COUNT


def test_tracers_take_turns_and_each_settles_before_it_is_timed(
    fake: Any, make: Callable[..., Config]
):
    fake(embree="Replaying", mitsuba_llvm="ReplayingToo")
    _, records = replayed(make(["embree", "mitsuba-llvm"], classes=["camera"]))
    asked = [line for line in fake.calls() if " load " not in line]
    both = [f"replaying {COUNT} closest", f"too {COUNT} closest"]
    assert asked == [f"{one} x2 counted" for one in both] + [f"{one} x2" for one in both] * 3
    rows = {(row["tracer"], row["traversal"]): row for row in records["camera"]["variants"]}
    # The last of two repeats counts; the call with the hits, which warms up, comes before.
    assert rows["embree", "intersect1"]["seconds"] == pytest.approx([0.002, 0.003, 0.004])
    assert rows["embree", "intersect1"]["visits"] == {"nodes": 5.0, "triangles": 2.0}
    # It sees nothing where the camera sees a ball: the control of the comparison.
    assert rows["embree", "intersect1"]["wrong"]["count"] > 10


def test_a_turn_may_hold_several_repeats_and_their_number_is_that_asked_for(
    fake: Any, make: Callable[..., Config]
):
    fake(embree="Replaying")
    _, records = replayed(make(["embree"], classes=["camera"], repeats=5, at_once=2))
    asked = [line for line in fake.calls() if " load " not in line]
    assert [line.split()[-1] for line in asked] == ["counted", "x3", "x3", "x2"]
    row = next(row for row in records["camera"]["variants"] if row["status"] == "ok")
    assert len(row["seconds"]) == 5


def test_a_way_that_a_tracer_lacks_is_skipped_with_its_reason(
    fake: Any, make: Callable[..., Config]
):
    fake(embree="Replaying", haste_cuda="Missing")
    config = make(
        ["haste-cuda", "haste-cpu", "embree"],
        classes=["camera"],
        traversals=["intersect1", "intersect8"],
    )
    _, records = replayed(config)
    reasons = {
        (row["tracer"], row["traversal"]): row["reason"]
        for row in records["camera"]["variants"]
        if row["status"] == "skipped"
    }
    assert reasons == {
        ("haste-cuda", ""): "no such machine: apt-get install one",
        ("embree", "intersect8"): "no packets here",
    }


def test_a_tracer_that_dies_fails_alone(fake: Any, make: Callable[..., Config]):
    fake(embree="DyingWhenTimed")
    _, records = replayed(make(["haste-cpu", "embree"], classes=["camera", "diffuse1"]))
    for record in records.values():
        rows = {row["tracer"]: row for row in record["variants"]}
        assert rows["haste-cpu"]["status"] == "ok" and len(rows["haste-cpu"]["seconds"]) == 3
        assert rows["embree"]["status"] == "failed" and "SIGABRT" in rows["embree"]["reason"]


def test_a_slow_tracer_is_given_rays_from_all_over_the_file(fake: Any, make: Callable[..., Config]):
    fake(embree="Replaying")
    _, records = replayed(make(["haste-cpu", "embree"], most={"embree": 64}))
    row = next(row for row in records["camera"]["variants"] if row["tracer"] == "embree")
    assert row["rays"] == 64 and row["differing"]["haste-cpu"]["rays"] == 64
    assert 0 < row["wrong"]["rays"] <= 64


def test_a_class_that_is_there_is_kept_and_one_that_is_not_is_traced_again(
    fake: Any, make: Callable[..., Config]
):
    fake(embree="Replaying")
    config = make(["embree"], classes=["camera", "diffuse1"])
    folder, first = replayed(config)
    sha256 = hash_file(folder / "rays.npz")
    (folder / "diffuse1.json").unlink()
    before = len(fake.calls())
    _, second = replayed(config)
    assert second["camera"] == first["camera"]
    assert second["diffuse1"]["key"] == first["diffuse1"]["key"]
    again = [line for line in fake.calls()[before:] if " load " not in line]
    assert len(again) == 1 + 3, again
    assert hash_file(folder / "rays.npz") == sha256
    _, third = replayed(make(["embree"], classes=["camera"], repeats=4))
    assert len(third["camera"]["variants"][0]["seconds"]) == 4


def test_the_log_tells_what_the_time_of_a_class_goes_into(
    make: Callable[..., Config], capsys: pytest.CaptureFixture[str]
):
    replayed(make(["haste-cpu"], classes=["camera"]))
    log = capsys.readouterr().err
    number = r"\d+\.\d"
    parts = ("reading", "looking", "comparing", "timing", "energy")
    spent = ", ".join(f"{part} {number}" for part in parts)
    assert re.search(rf"lamp: camera in {number} s \({spent}\)", log), log
    made = ", ".join(f"{part} {number}" for part in ("tracing", "making", "writing", "hashing"))
    assert re.search(rf"lamp: rays made in {number} s \({made}\)", log), log


def test_energy_is_asked_of_gpus_alone_and_the_reason_is_kept(make: Callable[..., Config]):
    config = make(["haste-cpu"], classes=["camera"], energy={"classes": ["camera"], "seconds": 0.1})
    _, records = replayed(config)
    rows = records["camera"]["variants"]
    assert {row["precision"] for row in rows} == {"watertight", "fast"}, rows
    for row in rows:
        assert row["joules"] is None and "NVML counts the energy of a GPU" in row["energy_reason"]


def test_rays_that_cannot_be_made_are_one_error(make: Callable[..., Config], scene_path: Path):
    config = make(["haste-cpu"])
    # A lamp by itself is lit by nothing.
    scene_path.write_text(scene_path.read_text().replace(BALL, ""))
    with pytest.raises(RaysError, match="nothing that the camera sees faces a light"):
        replay_scene(config, "lamp", 1)
