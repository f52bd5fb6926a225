"""provenance.json names the machine and the command of every part of a run."""

import json
import shutil
from pathlib import Path

from harness.tables.provenance import merge_provenance
from harness.tables.write import PARTS, write_tables

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
