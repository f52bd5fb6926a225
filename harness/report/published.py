"""Main figures of a published run, for the README and the documentation."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from harness.measure.config import ROOT
from harness.report.figures import MOST_PANELS, converging_panels, plot_packets, plot_plane
from harness.report.kinds import PUBLISHED_FIGURES
from harness.report.speed_figure import plot_speed
from harness.report.style import save_svg
from harness.tables.lookup import Measurements, find_measurements, read_measurements
from harness.tables.read import ResultsError
from harness.tables.trade import EXACT

PUBLISHED = ROOT / "results" / "published"
FOLDER = ROOT / "docs" / "images"


def newest_run(folder: Path = PUBLISHED) -> Path:
    """The published run of the latest date; raises ResultsError if there is none."""
    runs = sorted(path.parent for path in folder.glob("*/measurements.csv*"))
    if not runs:
        raise ResultsError(f"{folder}: no run is published here")
    return runs[-1]


def pictured_scenes(measurements: Measurements) -> list[str]:
    """Scenes that were timed and have no known answer, in the order of the file."""
    known = {row.scene for row in measurements.rows if row.quantity == "answer"}
    timed = [row.scene for row in measurements.rows if row.quantity == "samples_per_second"]
    return [scene for scene in dict.fromkeys(timed) if scene not in known]


def make_figures(measurements: Measurements) -> list[Figure | None]:
    """Speed by scene, time against error of the first scenes, rates over packet sizes."""
    scenes = pictured_scenes(measurements)
    models = list(dict.fromkeys(row.model for row in measurements.rows))
    panels = converging_panels(measurements, [(scene, EXACT) for scene in scenes])
    return [
        plot_speed(measurements, scenes),
        plot_plane(measurements, panels[:MOST_PANELS]),
        plot_packets(measurements, [(scene, model) for scene in scenes for model in models]),
    ]


def write_published(run: Path | None = None, folder: Path = FOLDER) -> list[Path]:
    """Write the figures of a published run, the newest by default; returns their paths.

    Raises ResultsError where the run cannot be read or has not measured what a figure shows.
    """
    run = run or newest_run()
    figures = make_figures(read_measurements(find_measurements(run)))
    paths = []
    for name, figure in zip(PUBLISHED_FIGURES, figures, strict=True):
        if figure is None:
            raise ResultsError(f"{run}: nothing was measured that {name} could show")
        paths.append(folder / f"{name}.svg")
        save_svg(figure, paths[-1])
    return paths
