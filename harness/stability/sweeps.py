"""Every hazard at every value through every tracer, in every precision that it has.

An error is that of the mean of the image against a closed form.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from harness.measure.config import Config
from harness.measure.crew import Crew
from harness.measure.files import find_record, hash_files, key_of, write_image, write_json
from harness.measure.messages import Render
from harness.measure.own_folder import own_folder
from harness.measure.progress import Progress
from harness.measure.provenance import provenance, tracer_code
from harness.scene import load_scene, load_settings
from harness.stability.hazards import HAZARDS, Extreme, Hazard
from harness.stability.mesh_scene import write_mesh
from harness.stability.modes import MODES, Image
from harness.statistics.intervals import t_interval
from harness.tracers.registry import TRACERS, load_tracer
from harness.whole_files import write_whole

HERE = Path(__file__).parent
KEPT = 1e-3
"""Error from which on the first image of a scene is kept for the report."""


def write_extreme(folder: Path, extreme: Extreme) -> Path:
    """Write a scene, its settings and its meshes to a folder, which is returned."""
    write_whole(folder / "settings.yaml", extreme.settings)
    for name, (vertices, triangles) in extreme.meshes.items():
        write_mesh(folder / f"{name}.ply", vertices, triangles)
    write_whole(folder / "scene.xml", extreme.scene)
    return folder


def measure_sweeps(config: Config, threads: int) -> Path:
    """Render every scene with every tracer in every precision, and take the errors.

    Returns
    -------
    Path
        The record: a row for each tracer, precision and scene.
    """
    path = config.sweeps_file
    folder = path.parent / "sweeps"
    with own_folder(folder, "sweeps", "sweeps") as progress:
        who = {tracer: tracer_code(tracer) for tracer in config["tracers"]}
        code = hash_files([HERE / "hazards.py", HERE / "seen_scene.py", Path(__file__)])
        key = key_of({"who": who, "plan": config["stability"]["sweeps"], "code": code})
        if find_record(path, key) is None:
            write_json(path, {"key": key, **_sweep(config, threads, folder, progress)})
    return path


def _sweep(config: Config, threads: int, folder: Path, progress: Progress) -> dict[str, Any]:
    """The rows, and where they come from."""
    plan = config["stability"]["sweeps"]
    scenes = [
        (hazard, value, write_extreme(folder / f"{hazard.name}-{value:g}", hazard.make(value)))
        for hazard in HAZARDS
        for value in plan["values"].get(hazard.name, [])
    ]
    rows: list[dict[str, Any]] = []
    for tracer in config["tracers"]:
        with Crew.of(config, [tracer], threads) as crew:
            able = tracer in crew.probe([tracer], "path")
            for hazard, value, scene in scenes:
                rows += _rows(crew, tracer, hazard, value, scene, plan, able=able)
        progress.say(f"{tracer}: {len(scenes)} scenes")
    about = provenance(config, load_scene(scenes[0][2]), threads) if scenes else {}
    return {"rows": rows, "provenance": about}


def _rows(
    crew: Crew,
    tracer: str,
    hazard: Hazard,
    value: float,
    scene: Path,
    plan: Mapping[str, Any],
    *,
    able: bool,
) -> Iterator[dict[str, Any]]:
    """A row for each precision of a tracer, of one scene."""
    own = load_tracer(TRACERS[tracer]).precision
    extreme = hazard.make(value)
    most = plan["most_samples"].get(tracer, math.inf)
    too_long = extreme.spp * extreme.size**2 > most
    ready = able and not too_long
    if ready:
        render = load_settings(scene).render("path", extreme.size, extreme.size)
        # Roulette would be noise.
        render = replace(render, max_depth=extreme.depth, rr_depth=extreme.depth + 1)
        ready = crew.load(tracer, scene, render) is not None
    for precision in MODES.get(tracer, (own,)):
        row: dict[str, Any] = {
            "tracer": tracer,
            "precision": precision,
            "hazard": hazard.name,
            "scene": hazard.scene,
            "value": value,
            "case": hazard.case(value),
        }
        if too_long:
            why = f"{extreme.spp * extreme.size**2} samples at once are more than it is given"
            yield row | {"status": "skipped", "reason": why}
        elif not ready:
            yield row | asdict(crew.absence(tracer))
        else:
            options = {"precision": precision} if tracer in MODES else {}
            found, image = _errors(crew, tracer, extreme, options, plan["images"])
            row |= found or asdict(crew.absence(tracer))
            off = abs(row["error"]["value"]) if row["status"] == "ok" else math.inf
            if image is not None and off > KEPT:
                row["image"] = f"{tracer}-{precision}.npy"
                write_image(scene / str(row["image"]), image)
            yield row


def _errors(
    crew: Crew, tracer: str, extreme: Extreme, options: Mapping[str, object], images: int
) -> tuple[dict[str, Any] | None, Image | None]:
    """The error of the mean and the samples that are no numbers, and the first image; None where
    the tracer fails.
    """
    errors: list[float] = []
    non_finite, first = 0, None
    for seed in range(images):
        request = Render(seed=seed, spp=extreme.spp, options=dict(options))
        result = crew.render(tracer, "path", request)
        if result is None:
            return None, None
        image = result.image
        first = image if first is None else first
        dropped = int(result.extras.get("non_finite", 0.0))
        non_finite += dropped + int((~np.isfinite(image)).any(axis=-1).sum())
        errors.append((float(np.mean(image)) - extreme.expected) / extreme.unit)
    count = {"non_finite": non_finite, "samples": images * extreme.spp * extreme.size**2}
    if not np.isfinite(errors).all():
        why = f"{non_finite} of {count['samples']} samples are not finite"
        return {"status": "failed", "reason": why, **count}, first
    return {"status": "ok", "reason": "", "error": asdict(t_interval(errors)), **count}, first
