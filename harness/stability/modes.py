"""Precision modes side by side on images: the same random numbers, so noise enters only where paths
part.

Images have one sample a pixel: a pixel whose two values are not alike is a path that parted.
"""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.measure.config import Config
from harness.measure.crew import Crew
from harness.measure.eye_rays import unshaded_settings
from harness.measure.files import hash_files, key_of, read_json, write_json
from harness.measure.messages import Render
from harness.measure.plan import subject_of
from harness.measure.progress import Progress
from harness.measure.provenance import provenance
from harness.scene import load_scene, load_settings
from harness.statistics.intervals import t_interval
from harness.statistics.metrics import luminance

Image = NDArray[np.float64]

MODES = {"haste-cpu": ("fp64", "watertight", "fast"), "haste-cuda": ("watertight", "fast")}
"""Precisions of each tracer; the first is what the others are compared with."""

ALIKE = 2.0**-10
"""Relative difference of a sample's luminance below which its path has not parted."""


def diverged(own: Image, other: Image) -> int:
    """Count the pixels of two images of the same random numbers that are not alike."""
    a, b = luminance(own), luminance(other)
    return int((np.abs(a - b) > ALIKE * np.maximum(a, b)).sum())


def compare_modes(config: Config, name: str, threads: int) -> Path:
    """Render a scene in every precision, and compare the images pixel by pixel.

    Parameters
    ----------
    config
        The run's settings.
    name
        One of the scenes of `modes` in its section `stability`.
    threads
        Processor threads of every tracer.

    Returns
    -------
    Path
        The record: a row for each tracer and precision.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    """
    scene_path, path = config.mode_scenes[name], config.modes_file(name)
    plan, progress = config["stability"]["modes"], Progress(name)
    settings = load_settings(scene_path)
    render = unshaded_settings(settings, *plan["resolution"])
    scene = load_scene(
        scene_path, width=render.width, height=render.height, recentre=settings.recentre
    )
    tracers = [tracer for tracer in config["tracers"] if tracer in MODES]
    keys = [
        subject_of(scene, tracer, render, threads, recentre=settings.recentre).key
        for tracer in tracers
    ]
    key = key_of({"who": keys, "plan": plan, "code": hash_files([Path(__file__)])})
    known = read_json(path)
    if isinstance(known, dict) and known.get("key") == key:
        return path
    rows: list[dict[str, Any]] = []
    with Crew(tracers, threads, config["timeout_seconds"]) as crew:
        able = crew.probe(tracers, render.model)
        for tracer in tracers:
            if tracer in able and crew.load(tracer, scene_path, render) is not None:
                rows += _compare(crew, tracer, render.model, plan["images"])
            gone = [row for row in crew.rows if row["tracer"] == tracer]
            rows += [{**row, "precision": MODES[tracer][0]} for row in gone]
            progress.say(f"precisions of {tracer}")
    about = provenance(config, scene, threads)
    samples = plan["images"] * render.width * render.height
    description = {"scene": scene.name, "model": render.model, "samples": samples}
    write_json(path, {"key": key, **description, "rows": rows, "provenance": about})
    return path


def _compare(crew: Crew, tracer: str, model: str, images: int) -> list[dict[str, Any]]:
    """A row for each precision; none where the tracer fails, which the crew notes."""
    names = MODES[tracer]
    bias: dict[str, list[float]] = {name: [] for name in names}
    seconds = dict.fromkeys(names, 0.0)
    parted, non_finite = dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    for seed in range(images):
        base: Image | None = None
        for name in names:
            request = Render(seed=seed, spp=1, options={"precision": name})
            result = crew.render(tracer, model, request)
            if result is None:
                return []
            base = result.image if base is None else base
            mean = float(luminance(base).mean())
            difference = float(luminance(result.image).mean()) - mean
            bias[name].append(difference / mean if mean else 0.0)
            parted[name] += diverged(result.image, base)
            non_finite[name] += int(result.extras.get("non_finite", 0.0))
            # The first render of a precision compiles, or warms the caches.
            seconds[name] += result.seconds if seed else 0.0
    return [
        {
            "tracer": tracer,
            "precision": name,
            "against": names[0],
            "status": "ok",
            "reason": "",
            "bias": asdict(t_interval(bias[name])),
            "diverged": parted[name],
            "non_finite": non_finite[name],
            "speed": seconds[names[0]] / seconds[name] if seconds[name] else None,
        }
        for name in names
    ]
