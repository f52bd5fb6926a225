"""The tests of stability as a job: what it writes, and what it makes of what tracers saw."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.measure.config import Config
from harness.measure.provenance import arithmetic
from harness.report.stability import crack_table, find_crack_rows, plot_cracks, surface_table
from harness.scene import SceneError, load_scene
from harness.stability.aims import AIMS
from harness.stability.job import measure_stability
from harness.stability.mesh_scene import largest_mesh, scaled, write_mesh_scene
from harness.stability.modes import compare_modes, diverged
from harness.stability.surfaces import measure_surfaces
from harness.tables.lookup import read_measurements
from harness.tables.schema import Recorder
from harness.tables.stability import (
    read_modes_jobs,
    read_stability_jobs,
    read_surfaces_job,
    record_modes,
    record_stability,
    record_surfaces,
    share_ppm,
)
from harness.tracers.haste import HasteCpu

REASON = HasteCpu.unavailable()
pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")

COUNT = 2048
LIT = """<scene version="3.0.0">
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0,3,5" target="0,0,0" up="0,1,0"/></transform>
  </sensor>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/></transform>
    <bsdf type="diffuse"/>
  </shape>
  <shape type="cube"><transform name="to_world"><rotate y="1" angle="30"/></transform></shape>
  <shape type="sphere">
    <point name="center" x="0" y="4" z="0"/>
    <emitter type="area"><rgb name="radiance" value="5,5,5"/></emitter>
  </shape>
</scene>
"""
SCALES, EYES = [1e-6, 1.0], [100.0]


def ball(rings: int) -> tuple[Any, Any]:
    """A closed sphere of 4 rings^2 triangles with a rough surface."""
    around = 2 * rings
    v, u = np.meshgrid(
        np.pi * (np.arange(rings) + 1.0) / (rings + 1.0),
        2.0 * np.pi * np.arange(around) / around,
        indexing="ij",
    )
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
    points *= np.random.default_rng(1).uniform(0.95, 1.0, v.shape)[..., None]
    vertices = np.concatenate([points.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    place = np.arange(rings * around).reshape(rings, around)
    beside = np.roll(place, -1, axis=1)
    pole = np.full(around, rings * around)
    parts = [
        np.stack([pole, place[0], beside[0]], axis=-1),
        np.stack([place[:-1], place[1:], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([place[:-1], beside[1:], beside[:-1]], axis=-1).reshape(-1, 3),
        np.stack([pole + 1, beside[-1], place[-1]], axis=-1),
    ]
    return vertices.astype(np.float32), np.concatenate(parts).astype(np.uint32)


@pytest.fixture
def make(make_config: Any, tmp_path: Path) -> Callable[..., Config]:
    """Settings for few rays at a ball."""
    folder = write_mesh_scene(tmp_path / "ball", *ball(16))

    def config(tracers: list[str], **changes: Any) -> Config:
        stability = {
            "scenes": [str(folder / "scene.xml")],
            "count": COUNT,
            "scales": SCALES,
            "eyes": EYES,
            "traversals": ["bvh2", "brute_force", "intersect1"],
            "seed": 3,
            "most": {},
            "modes": {"scenes": [], "resolution": [16, 16], "images": 2},
            "suites": ["surfaces", "sweeps"],
            "surfaces": {"scales": [1.0], "eyes": [1.0], "gaps": [1e-5], "images": 1},
            "sweeps": {"values": {}, "images": 2, "most_samples": {}},
        }
        return make_config(tracers=tracers, stability={**stability, **changes})

    return config


def test_every_tracer_is_judged_at_every_scale_eye_and_aim(make: Callable[..., Config]):
    config = make(["haste-cpu", "embree", "haste-cuda"])
    summary = measure_stability(config, "ball", 1)
    folder = config.stability_dir("ball")
    assert summary == folder / "stability.json" and not list(folder.glob("*.npz"))
    cases = set()
    caught = 0
    for scale in SCALES:
        for row in json.loads((folder / f"scale-{scale:g}.json").read_text())["rows"]:
            who = (row["tracer"], row["traversal"], row["precision"])
            cases.add((who, row["aim"], row["scale"], row["eye"]))
            if row["tracer"] == "haste-cuda":
                assert row["status"] in {"ok", "skipped"} and (row["reason"] or row["rays"])
                continue
            assert row["status"] == "ok", row
            assert 0.3 * row["rays"] < row["judged"] <= row["met"] <= row["rays"], row
            assert 0.0 <= row["ulp"][0] < 8.0 and row["ulp"][0] <= row["ulp"][1], row
            if row["precision"] != "fast":
                assert row["denied"] == 0, row
            if row["precision"] == "watertight":
                assert row["lost"] == 0 and row["first"] is None, row
            if row["precision"] == "fast":
                caught += row["lost"] > 0
                assert (row["first"] is not None) == (row["lost"] > 0), row
    assert caught > 8, f"fast tests lose rays in {caught} of 16 cases: these find no crack"
    ours = [("haste-cpu", way, "watertight") for way in ("bvh2", "brute_force")]
    ours.append(("haste-cpu", "bvh2", "fast"))
    for who in (*ours, ("embree", "intersect1", "robust"), ("embree", "intersect1", "fast")):
        assert {(who, aim, scale, EYES[0]) for aim in AIMS for scale in SCALES} <= cases, who
    before = {path: path.stat().st_mtime_ns for path in folder.glob("scale-*.json")}
    measure_stability(config, "ball", 1)
    assert before == {path: path.stat().st_mtime_ns for path in folder.glob("scale-*.json")}


def test_what_is_counted_becomes_rows_with_exact_intervals(make: Callable[..., Config]):
    config = make(["haste-cpu", "haste-cuda"], scales=[1.0])
    measure_stability(config, "ball", 1)
    (config.results_dir / "settings.json").write_text(json.dumps(config.values))
    (job,) = read_stability_jobs(config.results_dir)
    recorder = Recorder()
    record_stability(recorder, job)
    rows = [row for row in recorder.measurements if row["quantity"] == "cracks_ppm"]
    case = "aim=edge;eye=100.0;scale=1.0;traversal=bvh2"
    (row,) = [row for row in rows if row["precision"] == "watertight" and row["case"] == case]
    assert row["value"] == row["lower"] == 0.0 and row["status"] == "ok"
    # Of n tries without an event the one-sided bound is 1 - 0.025^(1/n).
    assert row["upper"] == pytest.approx(1e6 * (1.0 - 0.025 ** (1.0 / row["n"])), rel=1e-6)
    skipped = [row for row in rows if row["status"] == "skipped"]
    assert all(row["note"] for row in skipped)


def test_precisions_are_compared_with_the_same_random_numbers(
    make: Callable[..., Config], tmp_path: Path
):
    scene = tmp_path / "lit" / "scene.xml"
    scene.parent.mkdir()
    scene.write_text(LIT)
    modes = {"scenes": [str(scene)], "resolution": [48, 48], "images": 3}
    config = make(["haste-cpu", "embree", "haste-cuda"], scenes=[], modes=modes)
    path = compare_modes(config, "lit", 1)
    record = json.loads(path.read_text())
    rows = {(row["tracer"], row["precision"]): row for row in record["rows"]}
    assert record["samples"] == 3 * 48 * 48
    assert {precision for tracer, precision in rows if tracer == "haste-cpu"} == {
        *("fp64", "watertight", "fast")
    }
    assert not any(tracer == "embree" for tracer, _ in rows), "Embree has no such precisions"
    truth, single = rows["haste-cpu", "fp64"], rows["haste-cpu", "watertight"]
    assert truth["diverged"] == 0 and truth["bias"]["value"] == 0.0
    assert single["non_finite"] == 0 and single["diverged"] <= 8, single
    # Images that share no random number differ by some percent.
    assert abs(single["bias"]["value"]) < 1e-3, single
    assert ("haste-cuda", "watertight") in rows
    (config.results_dir / "settings.json").write_text(json.dumps(config.values))
    recorder = Recorder()
    for job in read_modes_jobs(config.results_dir):
        record_modes(recorder, job)
    recorded = {(row["quantity"], row["precision"]) for row in recorder.measurements}
    assert {("paired_bias", "fast"), ("diverged_ppm", "watertight")} <= recorded
    assert ("non_finite_ppm", "fp64") in recorded and ("paired_bias", "fp64") not in recorded


def test_rays_that_leave_surfaces_neither_come_back_nor_leak(make: Callable[..., Config]):
    surfaces = {"scales": [1e-6, 1e6], "eyes": [1.0, 1e3], "gaps": [1e-2, 1e-5], "images": 1}
    config = make(["haste-cpu", "haste-cuda", "mitsuba-scalar"], surfaces=surfaces)
    record = json.loads(measure_surfaces(config, 1).read_text())
    caught = 0
    for row in record["rows"]:
        if row["status"] != "ok":
            assert row["tracer"] != "haste-cpu" and row["reason"], row
            continue
        assert row["of"] == 64 * 64, row
        if row["tracer"] == "haste-cpu":
            assert row["count"] == 0, row
        caught += row["count"] > 0
    # Negative control: Mitsuba starts its rays further off than the lids are here.
    scalar = [row for row in record["rows"] if row["tracer"] == "mitsuba-scalar"]
    assert caught > 0 or not [row for row in scalar if row["status"] == "ok"]
    assert len([row for row in record["rows"] if row["tracer"] == "haste-cpu"]) == 24
    (config.results_dir / "settings.json").write_text(json.dumps(config.values))
    job, recorder = read_surfaces_job(config.results_dir), Recorder()
    assert job is not None
    record_surfaces(recorder, job)
    path = config.results_dir / "measurements.csv"
    recorder.frames()[1].to_csv(path, index=False)
    table = surface_table(read_measurements(path))
    assert table is not None
    ((_, body),) = table.groups
    assert [column.title for column in table.columns][2] == "self-hits"
    assert [cell.text for cell in body[0]][2:] == ["0"] * 3


def test_a_path_has_parted_where_a_sample_is_not_alike() -> None:
    own = np.full((2, 2, 3), 0.5)
    other = own.copy()
    other[0, 0] *= 1.0 + 2.0**-12
    other[1, 1] *= 1.01
    assert diverged(own, other) == 1 and diverged(own, own) == 0


def test_the_report_shows_what_was_lost_and_the_most_that_it_can_be(make: Callable[..., Config]):
    config = make(["haste-cpu", "embree", "haste-cuda"], scales=[1.0])
    measure_stability(config, "ball", 1)
    (config.results_dir / "settings.json").write_text(json.dumps(config.values))
    recorder = Recorder()
    for job in read_stability_jobs(config.results_dir):
        record_stability(recorder, job)
    path = config.results_dir / "measurements.csv"
    recorder.frames()[1].to_csv(path, index=False)
    rows = find_crack_rows(read_measurements(path))
    table = crack_table(rows)
    assert table is not None and plot_cracks(rows) is not None
    (_, body), *_ = table.groups
    by_way = {(line[0].text, line[1].text): line for line in body}
    ours = by_way["haste-cpu", "bvh2"]
    assert ours[2].text == "0" and ours[2].faint.startswith("< ")
    frame = table.frame.set_index(["tracer", "way"])
    assert frame.loc[("embree", "intersect1, fast"), "vertex"] > 0.0
    assert plot_cracks([]) is None and crack_table([]) is None


def test_single_precision_is_probed_and_whole() -> None:
    found = arithmetic()
    assert all(found.values()), found
    assert json.dumps(found)


def test_a_share_of_nothing_is_not_a_number() -> None:
    assert np.isnan(share_ppm(0, 0).value) and share_ppm(1, 4).value == 250_000.0


def test_the_largest_mesh_of_a_scene_is_taken_and_scaled(tmp_path: Path):
    vertices, triangles = ball(4)
    scene = load_scene(write_mesh_scene(tmp_path, scaled(vertices, 1e6), triangles))
    own, index = largest_mesh(scene)
    assert (own[index] == (vertices.astype(np.float64) * 1e6).astype(np.float32)[triangles]).all()


def test_a_scene_without_a_mesh_is_refused(scene_path: Path):
    with pytest.raises(SceneError, match="no mesh"):
        largest_mesh(load_scene(scene_path))
