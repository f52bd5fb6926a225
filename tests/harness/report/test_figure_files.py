"""Figures as parts of the page."""

from __future__ import annotations

import re
from pathlib import Path

from matplotlib import pyplot as plt

from harness.report.figure_files import embed
from harness.report.style import save_svg


def test_an_embedded_figure_keeps_no_style_sheet_and_only_ids_that_it_refers_to(
    tmp_path: Path,
) -> None:
    figure, axes = plt.subplots()
    axes.plot([1, 2, 3], [3, 1, 2], marker="o")
    path = tmp_path / "figure.svg"
    save_svg(figure, path)
    plt.close(figure)
    drawn = path.read_text()
    body = embed(drawn, "line")
    assert "<style" in drawn, "matplotlib writes no style sheet any more: embed need not remove it"
    assert "<style" not in body, body[:2000]
    ids = set(re.findall(r'\sid="([^"]+)"', body))
    referred = {
        name for pair in re.findall(r'url\(#([^)]+)\)|href="#([^"]+)"', body) for name in pair
    }
    referred.discard("")
    assert ids == referred, f"ids {sorted(ids)}, referred to {sorted(referred)}"
    assert ids, "nothing is referred to: the markers should be"
    assert all(name.startswith("line-") for name in ids), sorted(ids)
