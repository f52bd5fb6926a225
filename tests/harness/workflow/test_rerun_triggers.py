"""What a changed file has done again."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from runs import Run

from harness.measure.config import ROOT
from harness.measure.inputs import extension_path, module_sources, tracing_sources
from harness.tables import write_tables

STEPS = {
    "truth": "ground truth",
    "measure": "images and times of every tracer",
    "tables": "Tables of the run",
    "report": "Report of the run",
}


def planned(run: Run) -> set[str]:
    """The steps that a run would do again."""
    text = run.run("--dry-run")
    return {step for step, message in STEPS.items() if message in text}


@contextmanager
def changed(path: Path) -> Iterator[None]:
    """A file with another line at its end."""
    content, times = path.read_bytes(), path.stat()
    path.write_bytes(content + b"\n")
    try:
        yield
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_an_unchanged_run_has_nothing_to_do(undisturbed: Run):
    assert planned(undisturbed) == set()


@pytest.mark.parametrize(
    ("name", "steps"),
    [
        ("haste_cuda/nvrtc.py", {"measure", "tables", "report"}),
        ("reference/mitsuba/phong.py", {"truth", "measure", "tables", "report"}),
        ("harness/statistics/bias.py", {"tables", "report"}),
        ("harness/gate.py", {"report"}),
    ],
)
def test_a_changed_file_repeats_the_steps_that_read_it_and_no_others(
    undisturbed: Run, name: str, steps: set[str]
):
    with changed(undisturbed.folder / name):
        assert planned(undisturbed) == steps


def test_a_rebuilt_extension_is_an_input_of_images_and_times():
    extension = extension_path()
    assert extension is not None
    assert Path(tracing_sources()[-1]).name == extension.name, tracing_sources()


def imported(script: str, *arguments: str) -> set[str]:
    """Sources of the repository that a script has imported when it ends."""
    tell = (
        "\nimport json, sys\n"
        "files = [getattr(module, '__file__', None) for module in list(sys.modules.values())]\n"
        "print(json.dumps([file for file in files if file and file.endswith('.py')]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script + tell, *arguments],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    paths = [Path(file).resolve() for file in json.loads(done.stdout.splitlines()[-1])]
    own = [ROOT / name for name in ("harness", "haste_cuda", "reference")]
    return {
        str(path.relative_to(ROOT))
        for path in paths
        if any(path.is_relative_to(folder) for folder in own)
    }


@pytest.mark.parametrize(
    ("command", "module"),
    [("tables", "harness.tables.write"), ("report", "harness.report.write")],
)
def test_every_module_that_a_step_imports_is_among_its_sources(
    fabricate_results: Callable[..., Path], command: str, module: str
):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    write_tables(folder)
    command_line = imported("import harness.__main__")
    step = imported(
        "import sys\nfrom harness.__main__ import main\nassert main(sys.argv[1:]) == 0",
        *(command, "--results", str(folder)),
    )
    own = step - command_line
    assert len(own) > 10, own
    assert own <= set(module_sources(module)), own - set(module_sources(module))


def test_sources_follow_imports_within_functions_and_packages():
    names = module_sources("harness.measure.truth")
    for name in ("reference/mitsuba/truth.py", "reference/__init__.py", "harness/whole_files.py"):
        assert name in names, names
    assert "harness/gate.py" not in names, names
    assert module_sources("numpy", "harness.no_such_module") == []
