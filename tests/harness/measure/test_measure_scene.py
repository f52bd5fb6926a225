"""The job of one scene, with tracers that trace nothing."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import fake_tracers
import numpy as np
import pytest

from harness.measure.job import measure_scene
from harness.measure.progress import Progress


def timed(calls: list[str], start: int = 0) -> list[str]:
    return [call for call in calls[start:] if " timed" in call]


def files(folder: Path) -> dict[str, int]:
    """Every image and record of the scene with its time of change in nanoseconds."""
    return {
        str(path.relative_to(folder)): path.stat().st_mtime_ns
        for kind in ("seeds", "convergence")
        for path in sorted((folder / kind).rglob("*.*"))
    }


def test_tracers_take_turns_in_every_phase(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    config = make_config()
    measure_scene(config, "lamp", 1)
    calls = fake.calls()
    phases = timed(calls)
    # One counted render warms A up; B wants a second one, untimed by the job though not counted.
    assert phases.pop(0) == "B depth_first seed=0 spp=4 timed", calls
    assert [call.split()[0] for call in phases] == ["A", "B"] * (len(phases) // 2), phases
    wanted = 2 + 3 + 2 * 2
    assert len(phases) == 2 * wanted, phases


def test_rays_are_counted_apart_from_every_timed_render(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    config = make_config()
    measure_scene(config, "lamp", 1)
    calls = fake.calls()
    assert sum("counted" in call for call in calls) == 2, calls
    rows = json.loads((config.scene_dir("lamp") / "timing.json").read_text())
    assert len(rows) == 4
    for row in rows:
        assert row["rays"] == {"camera": 4, "shadow": 8, "ambient": 0, "bounce": 0}, row
        assert row["spp"] == 4 and row["load_seconds"] == 0.5 and row["status"] == "ok", row


def test_packet_sweep_visits_every_size_and_order_before_repeating_one(fake: Any, make_config: Any):
    fake(haste_cpu="Packets", embree="SteadyA")
    config = make_config()
    measure_scene(config, "lamp", 1)
    sweep = [call for call in timed(fake.calls()) if "packets" in call]
    one_round = [
        f"P packets seed=0 spp=2 timed packet={size} order={order}"
        for size in (1, 64)
        for order in ("fifo", "lifo")
    ]
    assert sweep == one_round * 2, sweep
    films = json.loads((config.scene_dir("lamp") / "scene.json").read_text())["films"]
    swept = next(row for row in films if row["tracer"] == "haste-cpu" and row["spp"] == 2)
    # Eight timed ones, and two counted: one by the plain engine, one by packets.
    assert swept["renders"] == 10, swept
    assert swept["different_films"] == 1, swept
    assert swept["engines"] == ["depth_first", "packets"], swept


def test_images_are_float32_files_with_a_record_of_seed_and_samples(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    config = make_config()
    measure_scene(config, "lamp", 1)
    folder = config.scene_dir("lamp")
    image = np.load(folder / "seeds/path/embree/seed_002.npy")
    record = json.loads((folder / "seeds/path/embree/seed_002.json").read_text())
    assert image.dtype == np.float32 and image.shape == (8, 8, 3)
    assert np.all(image == 2.0)
    assert (record["seed"], record["spp"], record["status"]) == (2, 4, "ok"), record
    convergence = sorted((folder / "convergence/path/haste-cpu").glob("*.npy"))
    names = [path.name for path in convergence]
    assert names == [f"spp_{n}_seed_{k}.npy" for n in (1, 2) for k in (0, 1)], names
    seeds = {float(np.load(path).flat[0]) for path in convergence}
    assert len(seeds) == 4 and min(seeds) >= 10_000, seeds


def test_a_second_run_renders_nothing(fake: Any, make_config: Any):
    fake(haste_cpu="Packets", embree="SteadyB")
    config = make_config()
    measure_scene(config, "lamp", 1)
    folder = config.scene_dir("lamp")
    before, calls = files(folder), len(fake.calls())
    measure_scene(config, "lamp", 1)
    assert fake.calls()[calls:] == []
    assert files(folder) == before
    assert json.loads((folder / "measured.json").read_text())["renders"] == 0


def test_more_seeds_render_only_the_new_ones_and_fewer_remove_the_rest(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    measure_scene(make_config(), "lamp", 1)
    calls = len(fake.calls())
    config = make_config(seeds={"count": 4})
    measure_scene(config, "lamp", 1)
    # A warm-up of the first tracer, two of the second, and one image of each.
    new = fake.calls()[calls:]
    assert sum("seed=3" in call for call in new) == 2 + 3, new
    assert len(timed(new)) == 2 + 3, new
    measure_scene(make_config(seeds={"count": 2}), "lamp", 1)
    left = sorted(path.name for path in config.scene_dir("lamp").rglob("seed_*.npy"))
    assert left == ["seed_000.npy"] * 2 + ["seed_001.npy"] * 2, left


def test_a_changed_sample_count_renders_again(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    measure_scene(make_config(), "lamp", 1)
    calls = len(fake.calls())
    changes = {"spp": {"path": 8}}
    config = make_config(seeds=changes, timing=changes)
    measure_scene(config, "lamp", 1)
    new = timed(fake.calls()[calls:])
    assert sum("spp=8" in call for call in new) >= 2 * (3 + 2), new
    rows = json.loads((config.scene_dir("lamp") / "timing.json").read_text())
    assert {row["spp"] for row in rows} == {8}, rows


def start_measuring(folder: Path, kind: str, **variables: str) -> subprocess.Popen[str]:
    """Start the scene's job with fake tracers, the first of them of a kind, in another process."""
    script = (
        "import sys; from pathlib import Path\n"
        "from harness.measure.config import load_config\n"
        "from harness.measure.job import measure_scene\n"
        "from harness.tracers.registry import TRACERS\n"
        "if __name__ == '__main__':\n"
        f"    TRACERS['haste-cpu'] = 'fake_tracers:{kind}'\n"
        "    TRACERS['embree'] = 'fake_tracers:SteadyB'\n"
        f"    measure_scene(load_config(Path({str(folder / 'config.json')!r})), 'lamp', 1)\n"
    )
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    return subprocess.Popen(
        [sys.executable, "-c", script],
        env={**os.environ, **variables, "PYTHONPATH": path},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_killed_run_goes_on_without_rendering_a_finished_image_again(
    fake: Any, make_config: Any, tmp_path: Path
):
    fake(haste_cpu="KillsItsParent", embree="SteadyB")
    config = make_config()
    folder = config.scene_dir("lamp")
    process = start_measuring(tmp_path, "KillsItsParent", FAKE_KILL="1")
    _, error = process.communicate()
    assert process.returncode == -signal.SIGKILL, error
    before = files(folder)
    assert sum(name.endswith(".npy") for name in before) == 4, before
    assert not (folder / "measured.json").exists()
    calls = len(fake.calls())
    measure_scene(config, "lamp", 1)
    after = files(folder)
    assert {name: after[name] for name in before} == before
    new = fake.calls()[calls:]
    assert not any("counted" in call for call in new), new
    assert (folder / "measured.json").exists()
    assert not list(folder.rglob(".partial-*"))


def test_of_two_jobs_of_one_scene_at_once_the_second_finds_what_the_first_has_rendered(
    fake: Any, make_config: Any, tmp_path: Path
):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    config = make_config()
    jobs = [start_measuring(tmp_path, "SteadyA") for _ in range(2)]
    said = [job.communicate()[1] for job in jobs]
    assert [job.returncode for job in jobs] == [0, 0], said
    together = fake.calls()
    folder = config.scene_dir("lamp")
    images = files(folder)
    measure_scene(config, "lamp", 1)
    assert fake.calls() == together, "something was left to render"
    assert files(folder) == images
    shutil.rmtree(folder)
    measure_scene(config, "lamp", 1)
    alone = fake.calls()[len(together) :]
    assert sorted(together) == sorted(alone), said
    waited = [text for text in said if "another process is at it" in text]
    assert len(waited) <= 1, said


def test_an_aborting_tracer_fails_alone_with_its_last_words(fake: Any, make_config: Any):
    fake(haste_cpu="Aborting", embree="SteadyB")
    config = make_config()
    measure_scene(config, "lamp", 1)
    folder = config.scene_dir("lamp")
    (row,) = json.loads((folder / "skipped.json").read_text())
    assert (row["tracer"], row["model"], row["status"]) == ("haste-cpu", "path", "failed")
    assert "SIGABRT" in row["reason"], row
    assert "kernel fault at pixel (3, 4)" in row["reason"], row
    assert len(list((folder / "seeds/path/embree").glob("*.npy"))) == 3
    assert len(list((folder / "seeds/path/haste-cpu").glob("*.npy"))) == 2
    record = json.loads((folder / "seeds/path/haste-cpu/seed_002.json").read_text())
    assert record["status"] == "failed" and "SIGABRT" in record["note"], record


def test_a_tracer_that_failed_in_one_model_is_tried_in_the_next(
    fake: Any, make_config: Any, scene_path: Path
):
    (scene_path.parent / "settings.yaml").write_text("models: [path, whitted]\n")
    fake(haste_cpu="Aborting", embree="SteadyB")
    config = make_config(models=["whitted", "path"])
    measure_scene(config, "lamp", 1)
    rows = json.loads((config.scene_dir("lamp") / "skipped.json").read_text())
    assert [(row["model"], row["status"]) for row in rows] == [
        ("whitted", "failed"),
        ("path", "failed"),
    ], rows


def test_what_cannot_run_is_a_skipped_row_with_its_reason(fake: Any, make_config: Any):
    fake(haste_cpu="Missing", embree="Picky", mitsuba_llvm="SteadyA")
    config = make_config(
        tracers=["haste-cpu", "embree", "mitsuba-llvm"], models=["path", "whitted"]
    )
    measure_scene(config, "lamp", 1)
    rows = json.loads((config.scene_dir("lamp") / "skipped.json").read_text())
    reasons = {(row["tracer"], row["model"]): row["reason"] for row in rows}
    assert reasons["haste-cpu", "path"] == "no such machine: apt-get install one", rows
    assert reasons["embree", "path"] == "the scene has a sphere", rows
    assert reasons["mitsuba-llvm", "whitted"] == "not among the models of the scene", rows
    assert all(row["status"] == "skipped" for row in rows), rows


def test_provenance_names_machine_versions_and_settings(fake: Any, make_config: Any):
    fake(haste_cpu="SteadyA", embree="SteadyB")
    config = make_config()
    measure_scene(config, "lamp", 3)
    found = json.loads((config.scene_dir("lamp") / "provenance.json").read_text())
    assert found["run"] == "test" and found["threads"] == 3
    assert found["packages"]["numpy"] == np.__version__
    assert found["machine"]["cores"] == os.cpu_count()
    assert found["config"]["seeds"]["count"] == 3
    assert len(found["scene"]["sha256"]) == 64


def test_progress_names_scene_model_tracer_and_count(capsys: pytest.CaptureFixture[str]):
    progress = Progress("lamp")
    progress.total = 1
    progress.step("path", "embree", "seeds")
    line = capsys.readouterr().err
    for part in ("lamp", "path", "embree", "1/1"):
        assert part in line, line


def test_the_fakes_log_variable_is_only_the_tests(fake: Any):
    assert os.environ[fake_tracers.LOG_VARIABLE].endswith("calls.log")
    assert fake.calls() == []


def test_every_engine_is_timed_once_before_any_is_timed_again(fake: Any, make_config: Any):
    fake(haste_cpu="Packets", embree="SteadyA")
    sweep = {"scenes": ["lamp"], "models": ["path"], "packets": [1, 64], "spp": 3, "repeats": 2}
    config = make_config(engines=sweep)
    measure_scene(config, "lamp", 1)
    calls = [call for call in timed(fake.calls()) if "spp=3" in call]
    one_round = [
        "P depth_first seed=0 spp=3 timed accumulation=flat",
        "P packets seed=0 spp=3 timed accumulation=flat packet=1",
        "P packets seed=0 spp=3 timed accumulation=flat packet=64",
    ]
    assert calls == one_round * 2, calls


def test_a_tracer_may_leave_out_small_packets(fake: Any, make_config: Any):
    fake(haste_cpu="Packets", embree="SteadyA")
    config = make_config(tracer_settings={"haste-cpu": {"least_packet": 2}})
    measure_scene(config, "lamp", 1)
    sweep = [call for call in timed(fake.calls()) if "packets" in call]
    assert sweep and all("packet=64" in call for call in sweep), sweep
