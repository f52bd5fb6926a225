"""The baseline: written and read back, renewed when somebody agrees, and held to."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.baseline import read_baseline, renew
from harness.bounds import GateSettings
from harness.gate import check

Fabricate = Callable[..., Path]
SMALL = {"scenes": ("cornell-box",), "models": ("path",), "seeds": 16, "spp": 256}
SETTINGS = GateSettings()


@pytest.fixture
def run(fabricate_results: Fabricate) -> Path:
    return fabricate_results(**SMALL)


@pytest.fixture
def baseline(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """A baseline made of the run itself."""
    folder = tmp_path / "baseline"
    assert renew(run, folder, SETTINGS, lambda: True) == 0
    capsys.readouterr()
    return folder


def change_images(run: Path, tracer: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    for path in (run / "scenes/cornell-box/seeds/path" / tracer).glob("*.npy"):
        np.save(path, change(np.load(path)).astype(np.float32))


def change_times(run: Path, tracer: str, factor: float) -> None:
    path = run / "scenes/cornell-box/timing.json"
    rows = json.loads(path.read_text())
    for row in rows:
        row["seconds"] *= factor if row["tracer"] == tracer else 1.0
    path.write_text(json.dumps(rows))


def test_a_run_is_as_good_as_its_own_baseline(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    assert check(run, baseline=baseline) == 0
    out = capsys.readouterr().out
    assert "baseline: 3 pass, 0 fail, 0 not enough samples" in out, out
    assert "2 same" in out, out


def test_a_written_baseline_reads_back(run: Path, baseline: Path):
    found = {row.subject: row for row in read_baseline(baseline)}
    row = found["cornell-box", "path", "embree"]
    assert row.seeds == tuple(range(16))
    assert (row.width, row.height, row.spp, row.tile_mean.shape) == (32, 32, 256, (4, 4))
    images = np.stack(
        [np.load(run / f"scenes/cornell-box/seeds/path/embree/seed_{k:03d}.npy") for k in range(16)]
    )
    light = images.astype(float) @ np.array([0.212671, 0.715160, 0.072169])
    assert row.means == pytest.approx(light.mean(axis=(1, 2)), rel=1e-6)
    assert row.log_seconds.size == 0
    assert found["cornell-box", "path", "haste-cpu"].log_seconds.size == 5


def test_an_image_that_is_not_the_baseline_s_is_named(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    change_images(run, "haste-cpu", lambda image: 1.006 * image)
    assert check(run, baseline=baseline) == 1
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "of the baseline's" in line]
    assert line.startswith("FAIL")
    assert "cornell-box path haste-cpu" in line
    assert "+0.600%" in line


def test_a_slower_tracer_fails_and_a_slower_machine_does_not(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    for tracer in ("haste-cpu", "embree", "mitsuba-llvm"):
        change_times(run, tracer, 1.7)
    assert check(run, baseline=baseline) == 0
    capsys.readouterr()
    change_times(run, "haste-cpu", 1.3)
    assert check(run, baseline=baseline) == 1
    lines = capsys.readouterr().out.splitlines()
    (line,) = [line for line in lines if "speed over" in line and "FAIL" in line]
    assert "embree's × 0.7" in line
    assert "slower" in line


def test_a_slower_tracer_on_another_processor_is_told_and_fails_nothing(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    path = baseline / "cornell-box.json"
    path.write_text(path.read_text().replace('"timed_on": "none', '"timed_on": "Babbage'))
    change_times(run, "haste-cpu", 1.3)
    assert check(run, baseline=baseline) == 0
    out = capsys.readouterr().out
    assert "1 slower" in out, out
    assert "speeds are no verdict here: it was timed on Babbage" in out, out


def test_a_slower_tracer_whose_speed_is_told_only_is_named_and_fails_nothing(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    change_times(run, "haste-cpu", 1.3)
    assert check(run, baseline=baseline, judge_speeds=False) == 0
    out = capsys.readouterr().out
    (line,) = [line for line in out.splitlines() if "speed over" in line]
    assert line.startswith("PASS"), line
    assert "haste-cpu" in line, line
    assert "slower" in line, line
    assert "speeds are told only" in out, out


def test_images_are_judged_where_speeds_are_told_only(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    change_images(run, "haste-cpu", lambda image: 1.006 * image)
    assert check(run, baseline=baseline, judge_speeds=False) == 1
    assert "of the baseline's" in capsys.readouterr().out


def test_images_of_another_size_are_not_compared(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    rows = json.loads((baseline / "cornell-box.json").read_text())
    for row in rows["snapshots"]:
        row["width"] = 64
    (baseline / "cornell-box.json").write_text(json.dumps(rows))
    assert check(run, baseline=baseline) == 0
    assert "3 not comparable: images or tiles of other sizes" in capsys.readouterr().out


def test_without_a_baseline_the_check_says_so(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert check(run, baseline=tmp_path / "none") == 0
    assert "./bench baseline makes one" in capsys.readouterr().out


def test_a_renewal_shows_what_it_changes_and_asks(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    before = (baseline / "cornell-box.json").read_bytes()
    change_images(run, "haste-cpu", lambda image: 1.02 * image)
    assert renew(run, baseline, SETTINGS, lambda: False) == 1
    out = capsys.readouterr().out
    assert "image +2.000%" in out, out
    assert "0 new, 0 gone, 1 different, 2 as they were" in out
    assert (baseline / "cornell-box.json").read_bytes() == before
    assert renew(run, baseline, SETTINGS, lambda: True) == 0
    assert (baseline / "cornell-box.json").read_bytes() != before
    capsys.readouterr()
    assert renew(run, baseline, SETTINGS, lambda: False) == 1
    assert "0 different, 3 as they were" in capsys.readouterr().out


def test_a_scene_that_is_gone_leaves_the_baseline(
    run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]
):
    text = (baseline / "cornell-box.json").read_text().replace("cornell-box", "attic")
    (baseline / "attic.json").write_text(text)
    assert renew(run, baseline, SETTINGS, lambda: True) == 0
    assert f"{'gone':<18} attic path embree" in capsys.readouterr().out
    assert not (baseline / "attic.json").exists()


def test_a_damaged_baseline_is_named(run: Path, baseline: Path, capsys: pytest.CaptureFixture[str]):
    (baseline / "cornell-box.json").write_text('{"scene": "cornell-box"}')
    assert check(run, baseline=baseline) == 1
    assert "cornell-box.json: not a scene of a baseline" in capsys.readouterr().err


def test_a_baseline_that_is_too_large_is_refused(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr("harness.baseline.MOST_BYTES", 1000)
    assert renew(run, tmp_path / "large", SETTINGS, lambda: True) == 1
    assert "at most 1000 may be committed" in capsys.readouterr().err
    assert not (tmp_path / "large").exists()
