"""Two fabricated runs: equal ones agree, a planted difference is named."""

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from harness.__main__ import main
from harness.compare import compare_ratios, compare_runs, ratio_p_value
from harness.statistics.intervals import Interval, log_ratio_interval
from harness.tables.lookup import Measurement, Measurements, read_measurements
from harness.tables.schema import Recorder, Subject

RATIOS = 60


def ratio(random: np.random.Generator, value: float, repeats: int = 6) -> Interval:
    """A ratio of two times with 2 % noise."""
    top, bottom = (random.lognormal(0.0, 0.02, repeats) for _ in range(2))
    return log_ratio_interval(value * top, bottom)


def write(path: Path, random: np.random.Generator, changed: dict[int, float]) -> Path:
    recorder = Recorder()
    for index in range(RATIOS):
        subject = Subject("run", f"scene-{index}", "haste-cuda", "haste", "packets", "watertight")
        value = changed.get(index, 1.0) * (1.0 + 0.01 * index)
        recorder.measure(subject, "reallocation_price", ratio(random, value), {"packet": 4096})
        recorder.measure(subject, "seconds", ratio(random, 1.0), {"spp": 4})
    recorder.frames()[1].to_csv(path, index=False)
    return path


def test_two_runs_of_the_same_thing_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    random = np.random.default_rng(21)
    first, second = (write(tmp_path / name, random, {}) for name in ("a.csv", "b.csv"))
    assert compare_runs(first, second) == 0
    assert f"{RATIOS} of {RATIOS} ratios agree" in capsys.readouterr().out


def test_a_planted_difference_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    random = np.random.default_rng(22)
    first = write(tmp_path / "a.csv", random, {})
    second = write(tmp_path / "b.csv", random, {17: 1.3})
    assert main(["compare", str(first), str(second)]) == 1
    (line, total) = capsys.readouterr().out.splitlines()
    assert line.startswith("DIFFERS") and "scene-17" in line
    assert f"{RATIOS - 1} of {RATIOS}" in total


def test_equal_ratios_are_seldom_far_apart_by_chance():
    random = np.random.default_rng(23)
    trials = 2000
    rejected = sum(
        ratio_p_value(ratio(random, 1.2), ratio(random, 1.2)) < 0.05 for _ in range(trials)
    )
    # Fewer than the level: degrees of freedom are counted low.
    most = stats.binom.ppf(1 - 1e-4, trials, 0.05)
    assert 0.02 * trials <= rejected <= most, rejected


def test_runs_without_a_ratio_in_common_do_not_agree(tmp_path: Path):
    path = tmp_path / "none.csv"
    Recorder().frames()[1].to_csv(path, index=False)
    assert compare_runs(path, path) == 1


def test_ratios_without_an_interval_are_left_out():
    nothing = Interval(1.0, float("nan"), float("nan"), 1)
    row = Measurement("s", "t", "m", "e", "", "speed_ratio", nothing, "1", "ok", "")
    assert compare_ratios(Measurements([row]), Measurements([row])) == []


def test_a_compressed_table_of_a_published_run_can_be_read(tmp_path: Path):
    import gzip

    plain = write(tmp_path / "a.csv", np.random.default_rng(24), {})
    packed = tmp_path / "a.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    assert read_measurements(packed).rows == read_measurements(plain).rows
