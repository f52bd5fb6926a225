"""Locks that end with their process."""

from __future__ import annotations

import errno
import fcntl
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from harness.locks import alone, join_runs

HOLD = (
    "import pathlib, sys, time\n"
    "from harness.locks import alone, join_runs\n"
    "path = pathlib.Path(sys.argv[2])\n"
    "def wait():\n"
    "    print('held', flush=True)\n"
    "    sys.stdin.read()\n"
    "if sys.argv[1] == 'alone':\n"
    "    with alone(path, print):\n"
    "        wait()\n"
    "else:\n"
    "    lock = join_runs(path)\n"
    "    wait()\n"
)


@contextmanager
def holder(kind: str, path: Path) -> Iterator[subprocess.Popen[str]]:
    """Another process that holds a lock until its input ends."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, kind, str(path)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin and process.stdout
    assert process.stdout.readline() == "held\n"
    try:
        yield process
    finally:
        process.stdin.close()
        process.wait()
        process.stdout.close()


def is_free(path: Path) -> bool:
    with path.open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True


def test_a_second_process_waits_and_says_so(tmp_path: Path):
    path = tmp_path / "new folder" / "lock"
    said: list[str] = []

    with holder("alone", path) as process:
        assert not is_free(path)

        def say(text: str) -> None:
            said.append(text)
            assert process.stdin
            process.stdin.close()

        with alone(path, say):
            assert process.wait() == 0
    assert said == [f"another process is at it ({path}); waiting until it has ended"]
    assert is_free(path)


def test_the_lock_of_a_killed_process_is_free(tmp_path: Path):
    path = tmp_path / "lock"
    with holder("alone", path) as process:
        process.send_signal(signal.SIGKILL)
        process.wait()
        said: list[str] = []
        with alone(path, said.append):
            assert said == [], f"killed with status {process.returncode}, and yet: {said}"


def snakemake_lock(folder: Path) -> Path:
    (folder / "locks").mkdir(parents=True)
    lock = folder / "locks" / "0.output.lock"
    lock.write_text("results/report.html\n")
    return lock


def test_the_only_run_clears_away_the_lock_of_a_killed_one(tmp_path: Path):
    lock = snakemake_lock(tmp_path)
    with holder("join", tmp_path) as process:
        assert not lock.exists()
        lock.touch()
        process.send_signal(signal.SIGKILL)
        process.wait()
        join_runs(tmp_path).close()
    assert not lock.exists()


def test_the_lock_of_a_run_that_is_alive_stays(tmp_path: Path):
    lock = snakemake_lock(tmp_path)
    with holder("join", tmp_path), holder("join", tmp_path):
        lock.touch()
        join_runs(tmp_path).close()
        assert lock.exists()
    assert lock.exists()


def test_a_file_system_without_locks_makes_nobody_wait_and_clears_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    lock = snakemake_lock(tmp_path)
    monkeypatch.setattr(fcntl, "flock", refuse)
    join_runs(tmp_path).close()
    assert lock.exists()
    said: list[str] = []
    with alone(tmp_path / "lock", said.append):
        assert said == [], said
