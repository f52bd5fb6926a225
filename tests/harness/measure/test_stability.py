"""The tests of stability as a job: what it writes, and what it makes of what tracers saw."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.measure.config import Config
from harness.scene import SceneError, load_scene
from harness.stability.aims import AIMS
from harness.stability.job import measure_stability
from harness.stability.mesh_scene import largest_mesh, scaled, write_mesh_scene
from harness.tables.schema import Recorder
from harness.tables.stability import read_stability_jobs, record_stability, share_ppm
from harness.tracers.haste import HasteCpu

REASON = HasteCpu.unavailable()
pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")

COUNT = 2048
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
            assert row["denied"] == 0, row
            if row["tracer"] == "haste-cpu":
                assert row["lost"] == 0 and row["first"] is None, row
            if row["precision"] == "fast":
                caught += row["lost"]
                assert (row["first"] is not None) == (row["lost"] > 0), row
    assert caught > 0, "the fast mode of Embree loses none: these rays find no crack"
    ours = [("haste-cpu", way, "watertight") for way in ("bvh2", "brute_force")]
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
    (row,) = [row for row in rows if row["tracer"] == "haste-cpu" and row["case"] == case]
    assert row["value"] == row["lower"] == 0.0 and row["status"] == "ok"
    # Of n tries without an event the one-sided bound is 1 - 0.025^(1/n).
    assert row["upper"] == pytest.approx(1e6 * (1.0 - 0.025 ** (1.0 / row["n"])), rel=1e-6)
    skipped = [row for row in rows if row["status"] == "skipped"]
    assert all(row["note"] for row in skipped)


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
