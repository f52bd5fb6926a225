"""Figures are saved as Matplotlib saves them, in less time."""

import io
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from harness.report.style import figure_style, make_panels, save_svg


def drawing() -> Figure:
    """Panels of different sizes: logarithms, mathematics, a legend outside, and a long label."""
    with figure_style():
        figure, (first, second) = make_panels(1, 2, 2.5)
        x = np.logspace(-3.0, 4.0, 20)
        first.loglog(x, x**-0.5, "o-", label=r"$\sigma / \sqrt{n}$")
        second.plot(x, 1e6 * x, label="a label that is longer than its line")
        second.set_ylabel("rays a second,\nin two lines")
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def test_a_figure_has_the_bytes_that_matplotlib_gives_it(tmp_path: Path):
    with figure_style():
        plain = io.StringIO()
        drawing().savefig(plain, format="svg", metadata={"Date": None, "Creator": "Haste"})
    wanted = [line.rstrip() for line in plain.getvalue().splitlines()]
    save_svg(drawing(), tmp_path / "figure.svg")
    found = (tmp_path / "figure.svg").read_text().splitlines()
    pairs = zip(found, wanted, strict=False)
    different = [number for number, (one, other) in enumerate(pairs) if one != other]
    same = len(found) == len(wanted) and not different
    assert same, f"{len(found)} lines, not {len(wanted)}; different: {different[:5]}"
    assert 'id="legend_1"' in "\n".join(wanted)


def test_a_figure_without_a_layout_is_saved_too(tmp_path: Path):
    figure = Figure(layout="none")
    figure.subplots().plot([1, 2])
    save_svg(figure, tmp_path / "plain.svg")
    assert "</svg>" in (tmp_path / "plain.svg").read_text()
