"""The job of the study of packets: it goes on where it was interrupted, and survives failures."""

import json
from pathlib import Path
from typing import Any

import pytest

from harness.measure.config import Config
from harness.measure.study import study_scene

STUDY = {
    "panels": {"lamp": ["path"]},
    "elsewhere": {"sizes": [64]},
    "tracers": ["haste-cpu"],
    "sizes": [16, 64],
    "width": 8,
    "launches": 2,
    "least_rays": 64,
    "repeats": 2,
    "price_repeats": 3,
    "memory": {"packet": 16, "spp": [1]},
    "timeline_packet": 64,
}


@pytest.fixture
def study(make_config: Any, scene_path: Path, fake: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run the study with a fake tracer: ``study(kind)`` gives its folder."""

    def run(kind: str = "Packets", **changes: Any) -> Path:
        fake(haste_cpu=kind)
        config: Config = make_config()
        config.values["study"] = {**config["study"], **STUDY, **changes}
        monkeypatch.setattr(
            Config, "study_scenes", property(lambda _: {"lamp": scene_path}), raising=True
        )
        return study_scene(config, "lamp", "path", 1).parent

    return run


def rows(folder: Path, file: str = "rows") -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((folder / f"{file}.json").read_text())
    return found


def test_every_case_is_looked_into_once_and_timed_in_turn(study: Any):
    folder = study()
    timed = [(row["engine"], json.dumps(row["case"]), row["repeat"]) for row in rows(folder)]
    assert len(timed) == len(set(timed)), timed
    # Repeats of one image size: the first of every case come before the second of any.
    wide = [(row["repeat"], row["width"]) for row in rows(folder)]
    by_width = [repeat for repeat, width in wide if width == 8]
    assert by_width == sorted(by_width), wide
    looked = rows(folder, "work")
    assert {row["key"] for row in rows(folder)} < {row["key"] for row in looked}
    assert len(looked) == len({row["key"] for row in looked})


def test_a_second_run_renders_nothing_again(study: Any, fake: Any):
    folder = study()
    before, calls = rows(folder), len(fake.calls())
    assert rows(study()) == before
    assert [call for call in fake.calls()[calls:] if "timed" in call] == []


def test_a_run_goes_on_with_what_is_missing(study: Any):
    folder = study()
    whole = rows(folder)
    (folder / "rows.json").write_text(json.dumps(whole[:5]))
    again = rows(study())
    assert again[:5] == whole[:5]
    assert sorted(row["key"] for row in again) == sorted(row["key"] for row in whole)


def test_rows_of_other_settings_are_forgotten(study: Any):
    study()
    folder = study(sizes=[16])
    assert {row["case"].get("packet", 16) for row in rows(folder)} == {16}


def test_a_size_that_fails_is_a_row_with_its_reason_and_the_rest_goes_on(study: Any):
    folder = study("FailsAtLargePackets")
    failed = [row for row in rows(folder, "work") if row["status"] == "failed"]
    assert failed and all("no room for 64 rays" in row["note"] for row in failed)
    assert all(row["case"].get("packet") != 64 for row in rows(folder))
    assert {row["case"].get("packet") for row in rows(folder)} >= {16}


def test_films_are_compared_over_engines(study: Any):
    description = json.loads((study() / "scene.json").read_text())
    assert description["films"], description
    for group in description["films"]:
        assert group["different_films"] == 1, group
