"""The report: self-contained, complete, deterministic."""

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from harness.report.write import write_report
from harness.tables import write_tables
from harness.tracers.registry import COLOURS

VOID = {"meta", "img", "br", "hr", "link", "input"}


@pytest.fixture(scope="module")
def report(fabricated_results: Path) -> Path:
    write_tables(fabricated_results)
    return write_report(fabricated_results)


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
def outline(report: Path) -> Outline:
    found = Outline()
    found.feed(report.read_text())
    return found


def test_the_page_is_well_formed_and_no_id_occurs_twice(outline: Outline):
    assert outline.open == []
    repeated = {name for name in outline.ids if outline.ids.count(name) > 1}
    assert not repeated


def test_the_page_loads_nothing_from_elsewhere(report: Path, outline: Outline):
    assert outline.sources
    assert all(source.startswith("data:image/png;base64,") for source in outline.sources)
    text = report.read_text()
    assert "<script" not in text
    assert "@import" not in text
    assert not re.findall(r"url\((?!#)", text)
    assert not [link for link in outline.links if link.startswith(("http:", "https:", "//"))]


def test_every_link_leads_somewhere(report: Path, outline: Outline):
    for link in outline.links:
        if link.startswith("#"):
            assert link[1:] in outline.ids, link
        else:
            assert (report.parent / link).is_file(), link


def test_every_figure_is_a_file_and_every_table_a_csv(report: Path):
    figures = {path.name for path in (report.parent / "figures").iterdir()}
    expected = {"agreement.svg", "packets.svg", "engines.svg"}
    for scene in ("cornell-box", "mirror-glass"):
        kinds = ("convergence", "plane", "trade")
        expected |= {f"{name}-{scene}.svg" for name in kinds}
    assert figures == expected
    tables = {path.name for path in (report.parent / "tables").iterdir()}
    names = ("verdicts", "skipped", "speed", "errors", "packets", "engines", "times")
    names += ("budget", "crossover")
    assert tables == {f"{name}.csv" for name in names}


def test_skipped_tracers_are_shown_with_their_reason(report: Path):
    text = report.read_text()
    assert "no NVIDIA driver: libcuda.so.1 cannot be opened" in text
    assert "compared in the model path only" in text
    assert "haste-cuda and mitsuba-cuda did not run here" in text


def test_a_tracer_has_its_colour_in_every_figure(report: Path):
    for path in (report.parent / "figures").glob("*.svg"):
        text = path.read_text()
        assert COLOURS["haste-cpu"].lower() in text, path.name
        assert COLOURS["haste-cuda"].lower() not in text, path.name


def test_writing_twice_gives_the_same_bytes(report: Path):
    paths = [report, *sorted((report.parent / "figures").iterdir())]
    before = [path.read_bytes() for path in paths]
    write_report(report.parent)
    for path, old in zip(paths, before, strict=True):
        assert path.read_bytes() == old, path.name


def test_figures_carry_no_date(report: Path):
    for path in (report.parent / "figures").glob("*.svg"):
        assert "<dc:date>" not in path.read_text(), path.name
