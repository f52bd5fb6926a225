"""provenance.json names the machine and the command of every part of a run."""

import json
import shutil
from pathlib import Path

import pytest

from harness.tables.provenance import PARTS, merge_provenance
from harness.tables.read import ResultsError
from harness.tables.write import write_tables

MACHINE = {"gpus": [{"uuid": "A"}]}


def test_what_scenes_share_stands_once_and_what_differs_by_its_job():
    one = {"run": "gpu", "commit": "c", "machine": MACHINE, "started": "1"}
    other = {**one, "started": "2"}
    elsewhere = {**one, "machine": {"gpus": [{"uuid": "B"}]}, "started": "3", "command": "prices"}
    merged = merge_provenance({"box": one, "skull": other}, {"features": {"box": elsewhere}})
    assert merged == {
        "run": "gpu",
        "commit": "c",
        "machine": MACHINE,
        "scenes": {"box": {"started": "1"}, "skull": {"started": "2"}},
        "features": {
            "box": {"machine": {"gpus": [{"uuid": "B"}]}, "started": "3", "command": "prices"}
        },
    }


def test_a_run_without_images_shares_what_its_other_jobs_do():
    one = {"run": "gpu", "commit": "c", "machine": MACHINE}
    merged = merge_provenance({}, {"study": {"skull": {**one, "started": "1"}, "box": one}})
    assert merged == {**one, "scenes": {}, "study": {"skull": {"started": "1"}, "box": {}}}


def test_a_run_that_measured_nothing_at_all_is_refused():
    with pytest.raises(ResultsError, match="nothing has been measured"):
        merge_provenance({}, {"rays": {}})


def test_every_part_of_a_run_stands_in_the_provenance_of_its_tables(
    studied_results: Path, tmp_path: Path
):
    folder = shutil.copytree(studied_results, tmp_path / "run")
    write_tables(folder)
    provenance = json.loads((folder / "provenance.json").read_text())
    assert set(PARTS) < set(provenance)
    panels = {f"{path.parent.name} {path.name}" for path in folder.glob("study/*/*")}
    assert panels
    assert set(provenance["study"]) == panels
