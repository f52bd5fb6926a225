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
from harness.measure.files import find_record, hash_files, key_of, write_json
from harness.measure.messages import Render
from harness.measure.provenance import provenance
from harness.measure.scene_job import SceneJob, scene_job
from harness.scene import RenderSettings
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
    plan, size = config["stability"]["modes"], tuple(config["stability"]["modes"]["resolution"])
    with scene_job(
        config, scene_path, path.parent, f"modes-{name}", threads, size=size, shared=True
    ) as job:
        render = unshaded_settings(job.settings, *size)
        tracers = [tracer for tracer in config["tracers"] if tracer in MODES]
        keys = [job.subject(tracer, render).key for tracer in tracers]
        key = key_of({"who": keys, "plan": plan, "code": hash_files([Path(__file__)])})
        if find_record(path, key) is None:
            samples = plan["images"] * render.width * render.height
            description = {"scene": job.scene.name, "model": render.model, "samples": samples}
            rows = _rows(job, tracers, render)
            about = provenance(config, job.scene, threads)
            write_json(path, {"key": key, **description, "rows": rows, "provenance": about})
    return path


def _rows(job: SceneJob, tracers: list[str], render: RenderSettings) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    with job.crew(tracers) as crew:
        able = crew.probe(tracers, render.model)
        for tracer in tracers:
            if tracer in able and crew.load(tracer, job.path, render) is not None:
                images = job.config["stability"]["modes"]["images"]
                rows += _compare(crew, tracer, render.model, images)
            gone = [row for row in crew.rows if row["tracer"] == tracer]
            rows += [{**row, "precision": MODES[tracer][0]} for row in gone]
            job.progress.say(f"precisions of {tracer}")
    return rows


def _compare(crew: Crew, tracer: str, model: str, images: int) -> list[dict[str, Any]]:
    """A row for each precision; none where the tracer fails, which the crew notes."""
    names = MODES[tracer]
    bias: dict[str, list[float]] = {name: [] for name in names}
    seconds = dict.fromkeys(names, 0.0)
    parted, non_finite = dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    base: Image | None = None
    for seed in range(images):
        base = None
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
    timed = 0 if base is None else (images - 1) * base.shape[0] * base.shape[1]
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
            "samples_per_second": timed / seconds[name] if seconds[name] else None,
        }
        for name in names
    ]
