"""The verdict on slopes, and its negative controls."""

import csv
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from scipy import stats

from harness.slopes import SlopeVerdict, describe_slopes, judge_slopes
from harness.statistics.bias import Verdict, exit_code_of

DEGREES = 60
COLUMNS = (
    "run,scene,tracer,model,engine,precision,case,quantity,value,lower,upper,unit,n,status,note"
)


def jobs(*, caustic: bool = False, miniature: bool = False) -> list[Any]:
    names = ("a", "b", "s")
    return [SimpleNamespace(name=name, caustic=caustic, miniature=miniature) for name in names]


def judge(
    folder: Path, values: dict[tuple[str, str], tuple[float, float]], **kind: bool
) -> list[SlopeVerdict]:
    """Slopes and their standard errors, written as the tables hold them, and judged."""
    file = folder / "measurements.csv"
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(COLUMNS.split(","))
        for (scene, tracer), (value, error) in values.items():
            half = stats.t.ppf(0.975, DEGREES) * error
            p_value = 2.0 * stats.t.sf(abs(value + 1.0) / error, DEGREES)
            subject = ("test", scene, tracer, "path", "depth_first", "native", "")
            slope = (value, value - half, value + half)
            writer.writerow([*subject, "slope", *slope, "1", 70, "ok", ""])
            writer.writerow([*subject, "slope_p_value", p_value, "", "", "1", 70, "ok", ""])
    return judge_slopes(file, jobs(**kind))


def test_slopes_near_minus_one_pass(tmp_path: Path):
    found = judge(tmp_path, {("a", "embree"): (-1.02, 0.02), ("b", "embree"): (-0.97, 0.02)})
    assert [row.verdict for row in found] == [Verdict.PASS, Verdict.PASS], found
    assert exit_code_of(row.verdict for row in found) == 0


def test_a_flattened_slope_fails_and_is_named(tmp_path: Path):
    found = judge(tmp_path, {("a", "embree"): (-0.9, 0.02), ("b", "embree"): (-1.0, 0.02)})
    assert [row.verdict for row in found] == [Verdict.FAIL, Verdict.PASS], found
    assert exit_code_of(row.verdict for row in found) == 1
    lines = describe_slopes(found)
    assert lines[0].startswith("FAIL")
    assert "a path embree" in lines[0]
    assert "1 exclude -1" in lines[-1]


def test_one_of_many_slopes_may_lie_two_errors_off(tmp_path: Path):
    """p = 0.03 alone; among twenty it is what chance gives."""
    many = {("s", f"tracer-{index}"): (-1.0, 0.02) for index in range(19)}
    found = judge(tmp_path, {**many, ("s", "off"): (-0.956, 0.02)})
    assert {row.verdict for row in found} == {Verdict.PASS}, found


def test_a_wide_interval_is_no_pass(tmp_path: Path):
    found = judge(tmp_path, {("a", "embree"): (-1.0, 0.04)})
    assert [row.verdict for row in found] == [Verdict.NOT_ENOUGH_SAMPLES], found
    assert exit_code_of(row.verdict for row in found) == 2


@pytest.mark.parametrize("kind", ["caustic", "miniature"])
def test_scenes_with_caustics_and_miniatures_are_left_out(tmp_path: Path, kind: str):
    found = judge(tmp_path, {("a", "embree"): (-0.8, 0.02)}, **{kind: True})
    assert found == []
    assert describe_slopes(found) == []
    assert exit_code_of(row.verdict for row in found) == 0


def test_a_run_without_a_table_has_no_slopes_to_judge(tmp_path: Path):
    assert judge_slopes(tmp_path / "measurements.csv", jobs()) == []
