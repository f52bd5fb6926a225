"""The figures of the documentation are those of the published runs."""

import json
import math
import re
from pathlib import Path

import pytest

from harness.measure.config import ROOT
from harness.report.kinds import PUBLISHED_FIGURES
from harness.report.published import (
    newest_of_each,
    read_runs,
    timed_scenes,
    write_published,
)
from harness.tables.read import ResultsError

RENEW = "renew them: .venv/bin/python -m snakemake published_figures"


def numbers_of(path: Path) -> list[str]:
    """What a figure says: its texts. Its lines may differ in the last digit between machines."""
    return re.findall(r"<text[^>]*>([^<]*)</text>", path.read_text())


def test_figures_of_the_documentation_are_those_of_the_published_runs(tmp_path: Path):
    for path in write_published(folder=tmp_path):
        committed = ROOT / "docs" / "images" / path.name
        assert committed.is_file(), RENEW
        assert numbers_of(committed) == numbers_of(path), f"{path.name}: {RENEW}"


def test_every_published_figure_is_shown_with_the_run_that_it_is_of():
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    text = "\n".join(page.read_text() for page in pages)
    for name in PUBLISHED_FIGURES:
        assert f"images/{name}.svg" in text, name


HEADER = (
    "run,scene,tracer,model,engine,precision,case,quantity,value,lower,upper,unit,n,status,note"
)


def publish(folder: Path, name: str, started: str, speeds: dict[str, float]) -> None:
    run = folder / name
    run.mkdir()
    (run / "provenance.json").write_text(json.dumps({"started": started}))
    rows = [
        f"gpu,{scene},haste-cuda,path,depth_first,watertight,,samples_per_second,"
        f"{speed},{speed},{speed},samples/s,10,ok,"
        for scene, speed in speeds.items()
    ]
    (run / "measurements.csv").write_text("\n".join([HEADER, *rows]) + "\n")


def test_every_scene_is_shown_as_the_run_that_started_last_has_found_it(tmp_path: Path):
    # In the order of their names the later run comes first.
    publish(tmp_path, "2026-01-02-h100-rays", "2026-01-02T12:00:00", {"skull": 2.0, "new": 3.0})
    publish(tmp_path, "2026-01-02-h100-trade", "2026-01-02T09:00:00", {"box": 1.0, "skull": 1.0})
    newest = newest_of_each(read_runs(tmp_path), timed_scenes)
    assert newest.scenes == ["box", "skull", "new"]
    shown = {row.scene: row.interval.value for row in newest.measurements.rows}
    assert shown == {"box": 1.0, "skull": 2.0, "new": 3.0}, newest.run_of


def test_runs_on_another_gpu_are_not_shown_among_them(tmp_path: Path):
    publish(tmp_path, "2026-01-02-h100", "2026-01-02T09:00:00", {"skull": 1.0})
    publish(tmp_path, "2026-01-03-h200", "2026-01-03T09:00:00", {"skull": 2.0})
    assert list(read_runs(tmp_path)) == ["2026-01-02-h100"]


def test_a_published_run_without_its_time_is_refused(tmp_path: Path):
    publish(tmp_path, "2026-01-02-h100", "", {"skull": 1.0})
    with pytest.raises(ResultsError, match=r"2026-01-02-h100/provenance\.json"):
        read_runs(tmp_path)


def test_table_of_the_readme_is_what_the_newest_run_of_each_scene_has_found():
    text = (ROOT / "README.md").read_text()
    header = re.search(r"^\| scene \| (.*) \|$", text, re.MULTILINE)
    assert header is not None
    tracers = header[1].split(" | ")
    rows = dict(re.findall(r"^\| ([a-z0-9-]+) \| ([0-9. |]+) \|$", text, re.MULTILINE))
    newest = newest_of_each(read_runs(), timed_scenes)
    assert list(rows) == newest.scenes
    for scene, cells in rows.items():
        for tracer, cell in zip(tracers, cells.split(" | "), strict=True):
            rate = newest.measurements.find(
                "samples_per_second", scene=scene, model="path", tracer=tracer
            )
            assert rate is not None, (scene, tracer)
            digits = len(cell.partition(".")[2])
            where = (scene, tracer, newest.run_of[scene], cell, rate.value)
            assert math.isclose(float(cell), rate.value * 1e-6, abs_tol=0.5 * 10**-digits), where
