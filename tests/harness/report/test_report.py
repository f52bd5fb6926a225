"""The report: self-contained, complete, deterministic."""

import html
import json
import re
import shlex
import subprocess
import sys
import zipfile
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import OpenEXR
import pandas as pd
import pytest
import yaml

from harness.measure.config import DEFAULT_PRESET, ROOT, check_config, merge
from harness.report.again import command_of
from harness.report.write import write_report
from harness.tables import write_tables
from harness.tracers.registry import COLOURS

VOID = {"meta", "img", "br", "hr", "link", "input"}


class Outline(HTMLParser):
    """Checks that tags close in order, and collects ids and addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.sources: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value or "")
            elif name == "src":
                self.sources.append(value or "")
            elif name == "href" and tag == "a":
                self.links.append(value or "")

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, f"</{tag}> at {self.getpos()} closes another element"


@pytest.fixture(scope="module")
def outline(written_report: Path) -> Outline:
    found = Outline()
    found.feed(written_report.read_text())
    return found


def test_the_page_is_well_formed_and_no_id_occurs_twice(outline: Outline):
    assert outline.open == []
    repeated = {name for name in outline.ids if outline.ids.count(name) > 1}
    assert not repeated


def test_the_page_loads_nothing_from_elsewhere(written_report: Path, outline: Outline):
    assert outline.sources
    assert all(source.startswith("data:image/png;base64,") for source in outline.sources)
    text = written_report.read_text()
    assert not re.findall(r"<script[^>]* src=", text)
    assert "@import" not in text
    assert not re.findall(r"url\((?!#)", text)
    assert not [link for link in outline.links if link.startswith(("http:", "https:", "//"))]


def test_every_link_leads_somewhere(written_report: Path, outline: Outline):
    for link in outline.links:
        if link.startswith("#view="):
            scene, model, tracer = link[6:].partition("&")[0].split("/")
            job = written_report.parent / "scenes" / scene
            assert (job / "seeds" / model / tracer).is_dir(), link
        elif link.startswith("#"):
            assert link[1:] in outline.ids, link
        else:
            assert (written_report.parent / link).is_file(), link


def test_every_figure_is_a_file_and_every_table_a_csv(written_report: Path):
    figures = {path.name for path in (written_report.parent / "figures").iterdir()}
    names = ("agreement", "packets", "engines", "spectrum", "quantiles", "speed")
    names += ("convergence-1", "plane-1", "trade-cornell-box", "trade-mirror-glass")
    expected = {f"{name}.svg" for name in names}
    assert figures == expected
    tables = {path.name for path in (written_report.parent / "tables").iterdir()}
    names = ("verdicts", "skipped", "speed", "errors", "packets", "engines", "times")
    names += ("budget", "crossover", "spectra", "resources")
    assert tables == {f"{name}.csv" for name in names}


def test_skipped_tracers_are_shown_with_their_reason(written_report: Path):
    text = written_report.read_text()
    assert "no NVIDIA driver: libcuda.so.1 cannot be opened" in text
    assert "compared in the model path only" in text
    assert "haste-cuda and mitsuba-cuda did not run here" in text


def test_a_tracer_has_its_colour_in_every_figure(written_report: Path):
    for path in (written_report.parent / "figures").glob("*.svg"):
        text = path.read_text()
        assert COLOURS["haste-cpu"].lower() in text, path.name
        assert COLOURS["haste-cuda"].lower() not in text, path.name


def test_every_row_has_a_command_whose_settings_can_be_used(written_report: Path):
    text = html.unescape(written_report.read_text())
    commands = re.findall(r'data-command="([^"]*)"', text)
    rows = re.findall(r"<tr><td", text.partition('<section id="trade">')[2])
    assert len(commands) >= len(rows) - 2 * 5 > 100
    whole = "./bench all --config results_dir=results/again"
    for command in set(commands):
        bench, target, option, *settings = shlex.split(command)
        assert [bench, target, option] == ["./bench", "all", "--config"], command
        changes = {key: yaml.safe_load(value) for key, value in map(split_setting, settings)}
        config = check_config(merge(yaml.safe_load(DEFAULT_PRESET.read_text()), changes))
        assert config["results_dir"] == "results/again", command
        assert len(config.scenes) == 1 or command == whole, command
    # Who was not run is said once of all scenes.
    skipped = pd.read_csv(written_report.parent / "tables" / "skipped.csv")
    assert commands.count(whole) <= skipped.groupby(["tracer", "reason"]).ngroups


def split_setting(text: str) -> tuple[str, str]:
    key, _, value = text.partition("=")
    return key, value


def test_a_command_of_the_miniature_renders_its_scene_and_nothing_beside():
    preset = ROOT / "config" / "check.yaml"
    config = merge(yaml.safe_load(DEFAULT_PRESET.read_text()), yaml.safe_load(preset.read_text()))
    command = shlex.split(
        command_of("verdicts", {"run": "check", "config": config}, "hard", "path")
    )
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", "--nolock", "--dry-run", *command[2:]],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "hard: ground truth" in said and "skull" not in said, said
    assert "the same rays" not in said and "engine" not in said, said
    assert "Rays that leave surfaces" not in said and "at their extremes" not in said, said


@pytest.mark.parametrize("table", ["cracks", "precisions", "surfaces", "stability_trade", "rays"])
def test_a_command_of_another_benchmark_renders_no_scene_and_its_own_jobs_alone(table: str):
    config = yaml.safe_load(DEFAULT_PRESET.read_text())
    command = command_of(table, {"run": "quick", "config": config})
    changes = dict(map(split_setting, shlex.split(command)[3:]))
    again = check_config(merge(config, {k: yaml.safe_load(v) for k, v in changes.items()}))
    every = table == "stability_trade"
    stability = again["stability"]
    assert again["scenes"] == [], command
    assert (again["rays"]["scenes"] != []) == (every or table == "rays"), command
    assert (stability["scenes"] != []) == (every or table == "cracks"), command
    assert (stability["modes"]["scenes"] != []) == (every or table == "precisions"), command
    suites = {"surfaces": ["surfaces"], "stability_trade": ["surfaces", "sweeps"]}
    assert stability["suites"] == suites.get(table, []), command


def test_a_page_holds_no_more_images_than_it_may_and_none_larger(
    fabricate_results: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
):
    folder = fabricate_results(
        scenes=("cornell-box",), models=("path", "whitted"), size=144, seeds=4, batches=4
    )
    write_tables(folder)
    monkeypatch.setattr("harness.report.sections.viewer.MOST_IMAGES", 6)
    page = write_report(folder).read_text()
    catalogue = json.loads(re.search(r'class="viewer-catalogue">(.*?)</script>', page)[1])
    sides = [
        -(-side // panel["block"])
        for panel in catalogue["panels"]
        for side in (panel["width"], panel["height"])
    ]
    thumbnails = re.findall(r'<img alt=[^>]* width="(\d+)" height="(\d+)"', page)
    inline = sum(len(panel["images"]) for panel in catalogue["panels"]) + len(thumbnails)
    assert thumbnails and catalogue["panels"] and catalogue["elsewhere"]
    assert inline <= 6, f"{inline} images in a page that may have 6"
    assert max([*sides, *(int(side) for pair in thumbnails for side in pair)]) <= 128
    with zipfile.ZipFile(folder / "report.zip") as archive:
        images = [name for name in archive.namelist() if name.endswith(".exr")]
        first = archive.read(images[0])
    assert len(images) == 4 + 3, images
    (folder / "one.exr").write_bytes(first)
    assert OpenEXR.File(str(folder / "one.exr")).channels()["RGB"].pixels.shape == (144, 144, 3)


def test_writing_twice_gives_the_same_bytes(written_report: Path):
    paths = [
        written_report,
        written_report.parent / "report.zip",
        *sorted((written_report.parent / "figures").iterdir()),
    ]
    before = [path.read_bytes() for path in paths]
    write_report(written_report.parent)
    for path, old in zip(paths, before, strict=True):
        assert path.read_bytes() == old, path.name


def test_figures_carry_no_date(written_report: Path):
    for path in (written_report.parent / "figures").glob("*.svg"):
        assert "<dc:date>" not in path.read_text(), path.name
