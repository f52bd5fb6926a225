"""A run that is killed, again and again, ends with what it would have had undisturbed."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pandas as pd
import pytest
import yaml
from runs import (
    Run,
    compare_mitsuba,
    finished,
    make_run,
    records,
    rows,
    tracers_images,
)

from harness.measure.config import ROOT

KILLS = 4
ROUNDING = 1e-5
"""Of Mitsuba's float32 sums, relative to the mean of the image: a hundred times the last bit."""


def progress(results: Path) -> int:
    """Files of the scenes' jobs that are finished."""
    return sum(1 for kind in ("*.npy", "*.json") for _ in (results / "scenes").rglob(kind))


def kill_later(process: subprocess.Popen[bytes], results: Path, enough: int, more: float) -> bool:
    """Kill a run's process group, by SIGKILL, some seconds after so many files are finished.

    Whether there was a run to kill: it may have ended before.
    """
    while progress(results) < enough and process.poll() is None:
        time.sleep(0.02)
    try:
        process.wait(timeout=more)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return True
    return False


def resume_through_kills(run: Run, kills: int, files: int, seed: int) -> list[str]:
    """Start a run anew after each of so many kills, spread over it, and let it end at last.

    Asserts after each that no finished batch has changed. Returns what was killed, a line each.
    """
    moments = random.Random(seed)
    log = []
    for share in sorted(moments.random() for _ in range(kills)):
        before = finished(run.results)
        process = run.start()
        killed = kill_later(process, run.results, int(share * files), moments.uniform(0.0, 2.0))
        after = finished(run.results)
        locks = len(list((run.folder / ".snakemake" / "locks").glob("*.lock")))
        log.append(
            f"{'killed' if killed else 'ended'} at {share:.2f} of the files: "
            f"{len(after)} finished batches, {locks} locks left"
        )
        assert killed or process.returncode == 0, run.said()
        changed = [name for name, content in before.items() if after.get(name) != content]
        assert not changed, (log, changed[:5])
    before = finished(run.results)
    run.run()
    after = finished(run.results)
    assert {name: after.get(name) for name in before} == before, log
    print(*log, sep="\n")
    return log


def assert_same(run: Run, undisturbed: Run, tmp_path: Path, log: list[str]) -> None:
    expected = tracers_images(undisturbed.results)
    assert tracers_images(run.results) == expected, log
    assert records(run.results) == records(undisturbed.results), log
    assert compare_mitsuba(undisturbed.results, run.results, ROUNDING) > 0
    tracers = ("haste-cpu", "haste-cuda", "embree")
    tables = [
        rows(one.results, undisturbed.results, tmp_path / name, tracers)
        for name, one in (("undisturbed-tables", undisturbed), ("tables", run))
    ]
    assert len(tables[0]) > len(expected), log
    pd.testing.assert_frame_equal(*tables)
    assert not list(run.results.rglob(".partial-*")), log


def test_a_run_killed_at_random_ends_as_one_that_was_not(tmp_path: Path, undisturbed: Run):
    run = make_run(tmp_path / "haste")
    log = resume_through_kills(run, KILLS, progress(undisturbed.results), seed=20)
    assert sum(line.startswith("killed") for line in log) >= KILLS - 1, log
    # What makes Snakemake refuse the next run.
    assert any("2 locks left" in line for line in log), log
    assert_same(run, undisturbed, tmp_path, log)
    assert "Nothing to be done" in run.run()


def test_a_preset_killed_twenty_times_ends_as_one_that_was_not(
    tmp_path: Path, pytestconfig: pytest.Config
):
    preset = pytestconfig.getoption("killed_preset")
    if preset is None:
        pytest.skip("renders a preset twice: --killed-preset config/check.yaml asks for it")
    settings = yaml.safe_load((ROOT / preset).read_text())
    undisturbed = make_run(tmp_path / "undisturbed", settings)
    undisturbed.run()
    run = make_run(tmp_path / "haste", settings)
    log = resume_through_kills(run, 20, progress(undisturbed.results), seed=20)
    assert_same(run, undisturbed, tmp_path, log)
