"""Files that appear whole or not at all: on a full disk, in a killed process, beside another."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from harness.__main__ import main
from harness.measure.files import remove_partial, write_image, write_json
from harness.report.style import save_svg
from harness.report.write import write_report
from harness.tables import write_tables
from harness.thumbnails import write_sheet
from harness.whole_files import PARTIAL, partial_files, write_whole, written_whole
from reference.mitsuba import truth

OLD = b"what was there before"


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """A file of more than so many bytes cannot be written: a disk that is full after as many."""
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, old[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def noise(*shape: int) -> np.ndarray:
    """An image that no compression makes smaller."""
    return np.random.default_rng(7).random(shape)


def write_sheet_of_one(path: Path) -> None:
    folder = path.parent / "scene"
    if not folder.exists():
        folder.mkdir()
        truth_of_colours = (noise(152, 152, 3) * 255).astype(np.uint8)
        import PIL.Image

        PIL.Image.fromarray(truth_of_colours).save(folder / "thumbnail.png")
    write_sheet([folder], path)


def save_figure(path: Path) -> None:
    figure = Figure()
    figure.subplots().plot(noise(500))
    save_svg(figure, path)


WRITERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "settings and records": ("a.json", lambda path: write_json(path, noise(4000).tolist())),
    "a tracer's image": ("a.npy", lambda path: write_image(path, noise(64, 64, 3))),
    "a batch of the truth": ("a.npy", lambda path: truth._write_batch(path, noise(64, 64, 3))),
    "the truth's mean": ("a.exr", lambda path: truth._write_exr(path, noise(64, 64, 3))),
    "the truth's record": (
        "truth.json",
        lambda path: truth._write_record(path.parent, {"a": "b" * 9999}),
    ),
    "a figure": ("a.svg", save_figure),
    "the sheet of thumbnails": ("a.jpg", write_sheet_of_one),
}


@pytest.mark.parametrize("what", WRITERS)
@pytest.mark.parametrize("old", [None, OLD], ids=["new", "over an old one"])
def test_a_full_disk_leaves_nothing_new_under_a_files_name(
    tmp_path: Path, what: str, old: bytes | None
):
    name, write = WRITERS[what]
    path = tmp_path / name
    write(path)
    size = path.stat().st_size
    path.unlink()
    if old is not None:
        path.write_bytes(old)
    before = contents(tmp_path)
    for room in (0, size // 3, size - 1):
        # OpenEXR raises RuntimeError with the system's own words.
        with room_for(room), pytest.raises((OSError, RuntimeError), match="too large"):
            write(path)
        assert contents(tmp_path) == before, f"{what}, of {size} bytes, with room for {room}"
    write(path)
    assert path.stat().st_size == size, what


def test_a_full_disk_leaves_both_tables_of_one_run(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    tables = ("samples.parquet", "measurements.csv", "provenance.json")
    write_tables(folder)
    before = contents(folder)
    sizes = sorted(len(before[name]) for name in tables)
    for file in (folder / "scenes").rglob("timing.json"):
        times = json.loads(file.read_text())
        file.write_text(json.dumps([{**row, "seconds": 2.0 * row["seconds"]} for row in times]))
    changed = contents(folder)
    # With room for the smaller ones, but not for the largest.
    for room in (100, *(size + 1 for size in sizes[:2])):
        with room_for(room), pytest.raises(OSError, match="too large"):
            write_tables(folder)
        assert contents(folder) == changed, room
    write_tables(folder)
    after = contents(folder)
    assert after["measurements.csv"] != before["measurements.csv"]


def test_a_full_disk_leaves_no_half_report(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    write_tables(folder)
    write_report(folder)
    complete = contents(folder)
    page = len(complete["report.html"])
    assert page > max(len(text) for name, text in complete.items() if name.endswith("svg"))
    with room_for(page - 1), pytest.raises(OSError, match="too large"):
        write_report(folder)
    assert contents(folder) == complete


def test_a_full_disk_is_one_line_and_exit_code_one(
    fabricate_results: Callable[..., Path], capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    with room_for(100):
        assert main(["tables", "--results", str(folder)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: [Errno 27]"), line
    assert line.endswith("what was complete is kept"), line


def test_a_block_that_raises_leaves_what_was_there(tmp_path: Path):
    paths = tmp_path / "a", tmp_path / "b"
    paths[0].write_bytes(OLD)

    def fail() -> None:
        with written_whole(*paths) as temporaries:
            for temporary in temporaries:
                temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert contents(tmp_path) == {"a": OLD}


def test_everything_is_on_the_disk_before_anything_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    events: list[str] = []
    flush, rename = os.fsync, Path.replace

    def note_flush(descriptor: int) -> None:
        events.append("flush " + Path(f"/proc/self/fd/{descriptor}").readlink().name[-1])
        flush(descriptor)

    def note_rename(self: Path, target: Path) -> Path:
        events.append("rename " + target.name)
        return rename(self, target)

    monkeypatch.setattr(os, "fsync", note_flush)
    monkeypatch.setattr(Path, "replace", note_rename)
    with written_whole(tmp_path / "a", tmp_path / "b") as temporaries:
        for temporary in temporaries:
            temporary.write_text("whole")
    assert events == ["flush a", "flush b", "rename a", "rename b"]


def test_files_have_the_permissions_of_any_new_file(tmp_path: Path):
    (tmp_path / "any").touch()
    write_whole(tmp_path / "whole", "text")
    modes = {path.name: oct(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert modes["whole"] == modes["any"], modes


def test_a_killed_process_leaves_its_partial_file_only(tmp_path: Path):
    path = tmp_path / "scene" / "truth" / "path" / "batch_000.npy"
    script = (
        "import pathlib, sys, time\n"
        "from harness.whole_files import written_whole\n"
        "with written_whole(pathlib.Path(sys.argv[1])) as (temporary,):\n"
        "    temporary.write_text('half')\n"
        "    time.sleep(60)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen([sys.executable, "-c", script, str(path)], env=environment)
    while not list(path.parent.glob("*")) and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not path.exists()
    scene = tmp_path / "scene"
    ((partial, wanted),) = partial_files(scene)
    assert wanted == path.relative_to(scene)
    # Whoever renders the images leaves alone what belongs to the truth: that may be at work.
    remove_partial(scene, of_truth=False)
    assert partial.exists()
    remove_partial(scene, of_truth=True)
    assert not list(scene.rglob(f"{PARTIAL}*"))


def test_processes_that_write_one_file_at_once_leave_one_of_their_texts(tmp_path: Path):
    path = tmp_path / "a.json"
    script = (
        "import pathlib, sys\n"
        "from harness.measure.files import write_json\n"
        "for k in range(100):\n"
        "    write_json(pathlib.Path(sys.argv[1]), [sys.argv[2]] * (1 + 997 * k % 5000))\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    writers = [
        subprocess.Popen([sys.executable, "-c", script, str(path), name], env=environment)
        for name in ("A", "B")
    ]
    seen = set()
    while any(writer.poll() is None for writer in writers):
        if path.exists():
            words = json.loads(path.read_text())
            assert len(set(words)) == 1, set(words)
            seen.add((words[0], len(words)))
    assert [writer.wait() for writer in writers] == [0, 0]
    assert len(seen) > 2, seen
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]
