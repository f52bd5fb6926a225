"""A model without ground truth, and folders of earlier runs, do not stop what can be judged."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.gate import check
from harness.report.write import write_report
from harness.tables import ResultsError, read_jobs, write_tables

REASON = "the truth of the model haste: no LLVM of version 16 or newer"


@pytest.fixture
def untrue(fabricate_results: Callable[..., Path]) -> Path:
    """Results of two scenes, of which cornell-box has no truth in the model haste."""
    folder = fabricate_results(models=("path", "haste"), size=16, seeds=4)
    scene = folder / "scenes" / "cornell-box"
    shutil.rmtree(scene / "truth" / "haste")
    skipped = [{"model": "haste", "reason": REASON}]
    (scene / "truth.json").write_text(json.dumps({"models": {}, "skipped": skipped}))
    return folder


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "measurements.csv").open() as file:
        return list(csv.DictReader(file))


def test_tables_have_a_skipped_row_with_the_reason_for_each_tracer(untrue: Path):
    write_tables(untrue)
    biases = [
        row
        for row in rows(untrue)
        if (row["scene"], row["model"]) == ("cornell-box", "haste")
        and row["quantity"] == "relative_bias"
    ]
    by_tracer = {row["tracer"]: row for row in biases}
    for tracer in ("haste-cpu", "embree"):
        assert by_tracer[tracer]["status"] == "skipped", by_tracer
        assert by_tracer[tracer]["note"] == f"no ground truth: {REASON}"
    assert by_tracer["haste-cuda"]["note"].startswith("no NVIDIA driver"), "the first reason stays"
    assert any(row["quantity"] == "seconds" and row["model"] == "haste" for row in rows(untrue))
    judged = {(row["scene"], row["model"]) for row in rows(untrue) if row["quantity"] == "relmse"}
    assert judged == {("cornell-box", "path"), ("mirror-glass", "path"), ("mirror-glass", "haste")}


def test_report_and_gate_go_on_and_give_the_reason(
    untrue: Path, capsys: pytest.CaptureFixture[str]
):
    write_tables(untrue)
    assert REASON in write_report(untrue).read_text()
    assert check(untrue) in {0, 2}, capsys.readouterr().out
    out = capsys.readouterr().out.splitlines()
    skipped = [line for line in out if line.startswith("skipped") and REASON in line]
    assert len(skipped) == 2, out
    assert any("mirror-glass haste haste-cpu" in line and "bias" in line for line in out), out


def test_a_truth_that_was_never_attempted_is_still_an_error(untrue: Path):
    (untrue / "scenes" / "cornell-box" / "truth.json").unlink()
    with pytest.raises(ResultsError, match="batches of truth"):
        write_tables(untrue)


def test_folders_of_an_earlier_run_are_not_judged(fabricated_results: Path, tmp_path: Path):
    folder = tmp_path / "results"
    shutil.copytree(fabricated_results, folder)
    settings = folder / "settings.json"
    assert [job.name for job in read_jobs(folder)] == ["cornell-box", "mirror-glass"]
    settings.write_text(json.dumps({"scenes": ["analytic/mirror-glass"]}))
    assert [job.name for job in read_jobs(folder)] == ["mirror-glass"]
    settings.write_text(
        json.dumps({"scenes": ["/elsewhere/mirror-glass/scene.xml", "/elsewhere/cornell-box.xml"]})
    )
    assert [job.name for job in read_jobs(folder)] == ["mirror-glass", "cornell-box"]


def test_a_scene_of_the_run_without_a_job_is_named(fabricated_results: Path, tmp_path: Path):
    folder = tmp_path / "results"
    shutil.copytree(fabricated_results, folder)
    (folder / "settings.json").write_text(json.dumps({"scenes": ["cornell-box", "skull"]}))
    with pytest.raises(ResultsError) as caught:
        read_jobs(folder)
    assert str(caught.value) == (
        f"{folder / 'scenes'}: no scene job of skull, which settings.json names; is the run "
        "complete?"
    )
