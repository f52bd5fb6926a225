"""What every job begins and ends with: a folder of its own, the scene, and records of both."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.locks import alone
from harness.measure.config import Config
from harness.measure.crew import Crew, NoHits
from harness.measure.files import find_record, write_json
from harness.measure.own_folder import own_folder
from harness.measure.scene_job import scene_job
from harness.scene import SceneError
from harness.whole_files import PARTIAL


@pytest.mark.parametrize(
    ("how", "left"),
    [
        ({}, {"truth"}),
        ({"of_truth": True}, {"rays.npz"}),
        ({"shared": True}, {"rays.npz", "truth"}),
    ],
)
def test_a_folder_is_cleared_of_what_is_half_written_and_of_nothing_else(
    tmp_path: Path, how: dict[str, bool], left: set[str]
):
    (tmp_path / "truth").mkdir()
    for name in ("rays.npz", "truth/mean.npy"):
        path = tmp_path / name
        path.with_name(f"{PARTIAL}0a1b-{path.name}").write_text("half")
        path.write_text("whole")
    with own_folder(tmp_path, "rays", "lamp", **how):
        partial = {path.relative_to(tmp_path) for path in tmp_path.rglob(f"{PARTIAL}*")}
    found = {"truth" if path.parts[0] == "truth" else "rays.npz" for path in partial}
    assert found == left, partial
    assert (tmp_path / "rays.npz").read_text() == "whole"
    assert (tmp_path / "truth" / "mean.npy").read_text() == "whole"


def test_a_folder_is_locked_for_one_kind_of_work_until_the_block_ends(tmp_path: Path):
    said: list[str] = []

    class TakenError(Exception):
        pass

    def refuse(text: str) -> None:
        said.append(text)
        raise TakenError

    with own_folder(tmp_path / "new", "rays", "lamp"):
        with pytest.raises(TakenError), alone(tmp_path / "new" / ".rays.lock", refuse):
            pass
        with alone(tmp_path / "new" / ".prices.lock", refuse):
            pass
    assert "waiting" in said[0] and len(said) == 1
    with alone(tmp_path / "new" / ".rays.lock", refuse):
        pass


def test_a_job_says_of_what_where_and_from_what_its_results_are(
    make_config: Callable[..., Config], scene_path: Path, tmp_path: Path
):
    folder = tmp_path / "job"
    with scene_job(make_config(), scene_path, folder, "rays", 2, size=(8, 4)) as job:
        assert (job.scene.camera.width, job.scene.camera.height) == (8, 4)
        job.note_provenance(rays={"count": 5})
        job.describe(triangles=len(job.scene.triangles))
        summary = job.finish("replayed.json", scene="lamp", failed=[])
    about = json.loads((folder / "provenance.json").read_text())
    assert about["rays"] == {"count": 5} and about["threads"] == 2
    assert about["scene"]["sha256"] == job.scene.sha256
    description = json.loads((folder / "scene.json").read_text())
    assert description.keys() == {"name", "title", "sha256", "triangles"}
    assert summary == folder / "replayed.json"
    assert json.loads(summary.read_text()) == {"scene": "lamp", "failed": []}


def test_a_scene_that_cannot_be_imported_leaves_no_record(
    make_config: Callable[..., Config], tmp_path: Path
):
    scene = tmp_path / "none"
    scene.mkdir()
    with (
        pytest.raises(SceneError),
        scene_job(make_config(), scene, tmp_path / "job", "rays", 1),
    ):
        pass
    assert [path.name for path in (tmp_path / "job").iterdir()] == [".rays.lock"]


@pytest.mark.parametrize("content", ["", "[1]", "{", '{"key": "other"}', '{"rows": []}'])
def test_a_record_of_something_else_is_none(tmp_path: Path, content: str):
    path = tmp_path / "record.json"
    assert find_record(path, "own") is None
    path.write_text(content)
    assert find_record(path, "own") is None
    write_json(path, {"key": "own", "rows": [1]})
    assert find_record(path, "own") == {"key": "own", "rows": [1]}


def test_of_a_tracer_that_was_dropped_twice_the_last_reason_counts():
    crew = Crew([], 1, 1.0)
    crew.drop("embree", "path", "skipped", "no scene")
    crew.drop("embree", "whitted", "failed", "killed by SIGABRT")
    crew.drop("haste-cuda", "path", "skipped", "no GPU")
    assert crew.absence("embree") == NoHits("failed", "killed by SIGABRT")
    assert crew.absence("haste-cuda") == NoHits("skipped", "no GPU")
    assert [row["tracer"] for row in crew.failed] == ["embree"]


def test_those_that_cannot_load_a_scene_are_not_ready(
    fake: Any, make_config: Callable[..., Config], scene_path: Path
):
    fake(embree="SteadyA", haste_cpu="Picky", haste_cuda="Missing")
    from harness.scene import load_settings

    render = load_settings(scene_path).render("path", 4, 4)
    tracers = ["embree", "haste-cpu", "haste-cuda"]
    with Crew.of(make_config(), tracers, 1) as crew:
        assert list(crew.ready(tracers, scene_path, render)) == ["embree"]
        assert crew.absence("haste-cpu") == NoHits("skipped", "the scene has a sphere")
