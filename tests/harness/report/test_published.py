"""The figures of the documentation are those of the published runs."""

import re
from pathlib import Path

from harness.measure.config import ROOT
from harness.report.kinds import PUBLISHED_FIGURES
from harness.report.published import write_published

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
