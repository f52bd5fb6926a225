"""Two runs at once: neither harms the other."""

from __future__ import annotations

from pathlib import Path

from runs import SETTINGS, Run, finished, make_run, records, tracers_images

SCENE = "three-spheres"


def test_of_two_runs_into_one_folder_one_completes_and_the_other_is_refused(
    tmp_path: Path, undisturbed: Run
):
    run = make_run(tmp_path / "haste", {**SETTINGS, "scenes": [SCENE]})
    processes = {log: run.start(log=log) for log in ("first.log", "second.log")}
    statuses = {log: process.wait() for log, process in processes.items()}
    said = {log: run.said(log) for log in statuses}
    assert 0 in statuses.values(), said
    for log, status in statuses.items():
        # Where one has ended before the other looks, both have.
        assert status == 0 or "Directory cannot be locked" in said[log], said
    assert (run.results / "report.html").is_file(), said
    expected = tracers_images(undisturbed.results)
    assert tracers_images(run.results) == {
        name: image for name, image in expected.items() if name.startswith(SCENE)
    }
    own = records(run.results)
    assert own == {name: records(undisturbed.results)[name] for name in own}
    assert set(finished(run.results)) == {
        name for name in finished(undisturbed.results) if name.startswith(SCENE)
    }
    assert not list(run.results.rglob(".partial-*"))
