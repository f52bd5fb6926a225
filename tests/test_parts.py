"""Several processes run the tests, and what belongs together stays in one of them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from parts import TOGETHER, part_of

TESTS = Path(__file__).parent
NOTE = """
import os, pathlib

def test_one():
    with pathlib.Path({notes!r}).open("a") as notes:
        print({name!r}, os.environ["PYTEST_XDIST_WORKER"], file=notes)
"""


@pytest.mark.parametrize("folder", TOGETHER)
def test_a_folder_that_shares_is_one_part_and_any_other_file_is_its_own(folder: str):
    assert (TESTS.parent / folder).is_dir(), f"{folder} is not there"
    assert part_of(f"{folder}/test_one.py::test_a[1]") == folder
    assert part_of(f"{folder}_two/test_one.py::test_a") == f"{folder}_two/test_one.py"
    assert part_of("tests/test_parts.py::test_a[x::y]") == "tests/test_parts.py"


def test_files_of_such_a_folder_run_first_and_in_one_process(tmp_path: Path):
    notes = tmp_path / "notes"
    names = ("tests/core/test_a.py", "tests/core/test_b.py", "tests/core/test_c.py")
    shared = tuple(f"{TOGETHER[0]}/test_{letter}.py" for letter in "xyz")
    for name in (*names, *shared):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(NOTE.format(notes=str(notes), name=name))
    for name in ("conftest.py", "parts.py"):
        shutil.copy(TESTS / name, tmp_path / "tests")
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n2", "--dist=loadfile", "-p", "no:cacheprovider"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    ran = dict(line.split() for line in notes.read_text().splitlines())
    assert set(ran) == {*names, *shared}, ran
    assert len({ran[name] for name in shared}) == 1, ran
    assert len(set(ran.values())) == 2, f"one process ran them all: {ran}"
    of_sharer = [name for name, worker in ran.items() if worker == ran[shared[0]]]
    assert tuple(of_sharer[: len(shared)]) == shared, ran
