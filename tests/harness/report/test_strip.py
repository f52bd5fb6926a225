"""The strip of verdicts: what truth, baseline and known answer say, and where it leads."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.baseline import renew
from harness.bounds import GateSettings
from harness.report.material import read_material
from harness.report.strip import Strip, make_strip
from harness.report.thumbnails import SIDE, shrink
from harness.tables import write_tables

BRIGHTER = 1.05


def strip_of(folder: Path, baseline: Path | None = None) -> Strip:
    write_tables(folder)
    return make_strip(read_material(folder, baseline))


def test_a_run_without_an_error_has_no_alarm(fabricated_results: Path, tmp_path: Path):
    folder = tmp_path / "results"
    shutil.copytree(fabricated_results, folder)
    strip = strip_of(folder)
    assert strip.alarms == [] and strip.more_alarms == 0
    assert all(kind != "fail" for _, kind, _, _ in strip.counts)
    absent = [mark for row in strip.rows for mark in row.marks if mark.kind == "none"]
    assert all(not mark.link for mark in absent)


def test_a_brighter_image_is_an_alarm_that_says_by_how_much(
    fabricate_results: Callable[..., Path],
):
    folder = fabricate_results(
        scenes=("cornell-box",), changes={"embree": lambda image: BRIGHTER * image}
    )
    strip = strip_of(folder)
    assert {alarm.tracer for alarm in strip.alarms} == {"embree"}
    first = strip.alarms[0]
    assert first.reason.startswith("bias +5.") or first.reason.startswith("bias +4."), first.reason
    assert first.link.startswith(f"#view=cornell-box/{first.model}/embree&mode=relative&x=")
    kinds = {mark.words.split(":")[0]: mark.kind for row in strip.rows for mark in row.marks}
    assert kinds["cornell-box, path, embree"] == "fail"
    assert kinds["cornell-box, path, haste-cpu"] == "pass"


@pytest.mark.parametrize(("factor", "kind"), [(1.0, "same"), (2.0, "slower")])
def test_a_speed_stands_beside_the_baselines(
    fabricate_results: Callable[..., Path], tmp_path: Path, factor: float, kind: str
):
    folder = fabricate_results(scenes=("cornell-box",), models=("path",))
    write_tables(folder)
    baseline = tmp_path / "baseline"
    baseline.mkdir()
    assert renew(folder, baseline, GateSettings(), lambda: True) == 0
    slow_down(folder / "scenes" / "cornell-box" / "timing.json", "haste-cpu", factor)
    strip = strip_of(folder, baseline)
    marks = {mark.words.split(":")[0]: mark for row in strip.rows for mark in row.marks}
    assert marks["cornell-box, path, haste-cpu"].speed_kind == kind
    assert marks["cornell-box, path, haste-cpu"].kind == "pass", "the image is as it was"
    told = [alarm.reason for alarm in strip.alarms if alarm.link == "#speed"]
    assert bool(told) == (kind == "slower"), strip.alarms


def slow_down(timing: Path, tracer: str, factor: float) -> None:
    rows = json.loads(timing.read_text())
    for row in rows:
        if row["tracer"] == tracer:
            row["seconds"] *= factor
    timing.write_text(json.dumps(rows))


def test_thumbnails_are_means_of_squares_and_small():
    image = np.arange(300 * 200 * 3, dtype=float).reshape(300, 200, 3)
    small = shrink(image)
    assert max(small.shape) <= SIDE
    assert small.shape == (100, 66, 3)
    np.testing.assert_allclose(small[0, 0], image[:3, :3].mean(axis=(0, 1)))
    assert shrink(image[:50, :40]).shape == (50, 40, 3)
