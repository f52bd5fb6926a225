"""Main figures of the published runs, for the README and the documentation."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from harness.measure.config import ROOT, find_scene
from harness.report.features import find_prices, plot_prices
from harness.report.figures import MOST_PANELS, converging_panels, plot_packets, plot_plane
from harness.report.kinds import PUBLISHED_FIGURES
from harness.report.rays import find_ray_rows
from harness.report.rays_figures import plot_ray_ratios
from harness.report.speed_figure import plot_speed
from harness.report.style import save_svg
from harness.report.trade_figure import plot_trade
from harness.scene import load_settings
from harness.tables.knobs import KNOBS
from harness.tables.lookup import Measurements, find_measurements, read_measurements
from harness.tables.read import MODELS, ResultsError
from harness.tables.schema import parse_case
from harness.tables.trade import EXACT

PUBLISHED = ROOT / "results" / "published"
FOLDER = ROOT / "docs" / "images"
OPTIX = "mitsuba-cuda"
GPU = "h100"
"""The GPU of the documentation's figures, as the folders of its runs name it."""


@dataclass(frozen=True, slots=True)
class Subject:
    """A scene of a published run, which has no job any more."""

    name: str
    description: Mapping[str, Any]


def timed_scenes(measurements: Measurements) -> list[str]:
    """Scenes that were timed and have no known answer, in the order of the file."""
    known = {row.scene for row in measurements.rows if row.quantity == "answer"}
    rows = [row for row in measurements.rows if row.quantity == "samples_per_second"]
    timed = [row.scene for row in rows if not row.case]
    return [scene for scene in dict.fromkeys(timed) if scene not in known]


def converging_scenes(measurements: Measurements) -> list[str]:
    """Scenes with images of `path` at several sample counts."""
    panels = [(scene, EXACT) for scene in timed_scenes(measurements)]
    return [scene for scene, _ in converging_panels(measurements, panels)]


def swept_scenes(measurements: Measurements) -> list[str]:
    """Scenes of the sweep of packet sizes; rows of the study name their light samples beside."""
    rows = [row for row in measurements.rows if row.engine == "packets" and row.status == "ok"]
    cases = [(row.scene, parse_case(row.case).keys()) for row in rows]
    return list(
        dict.fromkeys(
            name for name, keys in cases if "order" in keys and "light_samples" not in keys
        )
    )


def turned_scenes(measurements: Measurements) -> list[str]:
    """Scenes whose knobs were turned."""
    rows = [row for row in measurements.rows if row.quantity == "crossover_seconds"]
    return list(
        dict.fromkeys(row.scene for row in rows if set(KNOBS) & parse_case(row.case).keys())
    )


def traced_scenes(measurements: Measurements) -> list[str]:
    """Scenes whose rays both ours and OptiX have traced."""
    rows = [row for row in find_ray_rows(measurements) if row.tracer == "haste-cuda"]
    compared = [row.scene for row in rows if any(other == OPTIX for other, _ in row.ratios)]
    return list(dict.fromkeys(compared))


def priced_scenes(measurements: Measurements) -> list[str]:
    """Scenes whose features were priced in time."""
    return list(
        dict.fromkeys(row.scene for row in measurements.rows if row.quantity == "feature_price")
    )


def _speed(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    return plot_speed(measurements, scenes)


def _planes(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    return plot_plane(measurements, [(scene, EXACT) for scene in scenes[:MOST_PANELS]])


def _packets(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    return plot_packets(measurements, [(scene, model) for scene in scenes for model in MODELS])


def _trade(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    settings = load_settings(find_scene(scenes[0]))
    subject = Subject(scenes[0], {"settings": {"max_depth": settings.max_depth}})
    return plot_trade(measurements, subject)


def _rays(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    del scenes
    return plot_ray_ratios(find_ray_rows(measurements), OPTIX)


def _features(measurements: Measurements, scenes: Sequence[str]) -> Figure | None:
    del scenes
    return plot_prices(find_prices(measurements), EXACT)


Scenes = Callable[[Measurements], list[str]]
Plot = Callable[[Measurements, Sequence[str]], Figure | None]
SPECIFIED: tuple[tuple[Scenes, Plot], ...] = (
    (timed_scenes, _speed),
    (converging_scenes, _planes),
    (turned_scenes, _trade),
    (swept_scenes, _packets),
    (traced_scenes, _rays),
    (priced_scenes, _features),
)
"""What each of PUBLISHED_FIGURES is about, and how it is drawn."""


def last_start(run: Path) -> str:
    """When the last part of a run began, ISO 8601; raises ResultsError where it does not say."""
    text = (run / "provenance.json").read_text()
    starts: list[str] = re.findall(r'"started": "([^"]+)"', text)
    if not starts:
        raise ResultsError(f"{run / 'provenance.json'}: no part of the run says when it started")
    return max(starts)


def read_runs(folder: Path = PUBLISHED) -> dict[str, Measurements]:
    """Every published run on the GPU of the documentation by its name, the oldest first.

    Raises ResultsError if there is none.
    """
    found = [path.parent for path in folder.glob(f"*-{GPU}*/measurements.csv*")]
    runs = sorted(found, key=last_start)
    if not runs:
        raise ResultsError(f"{folder}: no run on an {GPU} is published here")
    return {run.name: read_measurements(find_measurements(run)) for run in runs}


@dataclass(frozen=True, slots=True)
class Newest:
    """Scenes, each as the newest run that has measured it in some way found it."""

    measurements: Measurements
    run_of: Mapping[str, str]
    """The runs of the scenes, in the order in which the scenes were first measured."""

    @property
    def scenes(self) -> list[str]:
        """The scenes in that order."""
        return list(self.run_of)


def newest_of_each(runs: Mapping[str, Measurements], scenes_of: Scenes) -> Newest:
    """Put together what the runs, the oldest first, say of scenes that were measured in one way."""
    run_of = {scene: name for name, run in runs.items() for scene in scenes_of(run)}
    rows = [row for name, run in runs.items() for row in run.rows if run_of.get(row.scene) == name]
    return Newest(Measurements(rows), run_of)


def write_published(folder: Path = FOLDER) -> dict[Path, list[str]]:
    """Write the figures, every scene in them as its newest run found it.

    Returns their paths with the names of the runs. Raises ResultsError where no run has measured
    what a figure shows.
    """
    runs = read_runs()
    written = {}
    for name, (scenes_of, plot) in zip(PUBLISHED_FIGURES, SPECIFIED, strict=True):
        newest = newest_of_each(runs, scenes_of)
        figure = plot(newest.measurements, newest.scenes) if newest.scenes else None
        if figure is None:
            raise ResultsError(f"{PUBLISHED}: no run has measured what {name} shows")
        path = folder / f"{name}.svg"
        save_svg(figure, path)
        written[path] = sorted(set(newest.run_of.values()))
    return written
