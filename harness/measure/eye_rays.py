"""The eye rays of a scene with a published count: every tracer, once, and double precision."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from harness.eye_rays import Seen, corner_rays, count_differences
from harness.measure.crew import Crew, NoHits
from harness.measure.files import find_record, hash_files, key_of, write_json
from harness.measure.messages import Trace
from harness.measure.plan import subject_of
from harness.scene import RenderSettings, Settings, load_scene, load_settings

RECORD = "eye_rays.json"

ROOT = Path(__file__).resolve().parents[2]
OWN_CODE = (
    "harness/eye_rays.py",
    "harness/measure/eye_rays.py",
    "harness/tracers/mitsuba.py",
    "harness/tracers/mitsuba_rays.py",
    "harness/tracers/rays.py",
    "reference/pinhole.py",
)
"""What the record depends on beside the code of the images."""


def measure_eye_rays(
    crew: Crew, tracers: Sequence[str], scene_path: Path, folder: Path
) -> Path | None:
    """Trace a scene's eye rays with every tracer, and write eye_rays.json.

    Rays go through the corners of the pixels of the scene's own film. A record of the same scene,
    tracers and code is kept. Tracers that cannot are in the record with the reason; the rows of the
    scene's images are not touched.

    Parameters
    ----------
    crew
        The workers. Each is left with this scene at the film's own size.
    tracers
        Names in the registry, in the order of the record.
    scene_path
        The scene: a folder or an XML file.
    folder
        Where the record is written.

    Returns
    -------
    Path | None
        The record; None where the scene's settings have no published count.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    """
    path = folder / RECORD
    settings = load_settings(scene_path)
    if settings.eye_rays is None:
        path.unlink(missing_ok=True)
        return None
    scene = load_scene(scene_path, recentre=settings.recentre)
    render = unshaded_settings(settings, scene.camera.width, scene.camera.height)
    keys = [
        subject_of(scene, tracer, render, crew.threads, recentre=settings.recentre).key
        for tracer in tracers
    ]
    code = hash_files(ROOT / file for file in OWN_CODE)
    key = key_of({"tracers": keys, "published": asdict(settings.eye_rays), "code": code})
    if find_record(path, key) is not None:
        return path

    from reference.pinhole import closest_hits

    origins, directions = corner_rays(scene.camera)
    exact = closest_hits(scene, origins, directions)
    reference = Seen(exact.t, exact.primitive)
    seen: dict[str, Seen] = {}
    rows: dict[str, dict[str, Any]] = {}
    for tracer in tracers:
        answer = crew.trace(tracer, scene_path, render, Trace(origins, directions))
        if isinstance(answer, NoHits):
            rows[tracer] = asdict(answer)
            continue
        seen[tracer] = Seen(answer.t, answer.primitive)
        rows[tracer] = {
            "status": "ok",
            "hits": seen[tracer].hits,
            "disagreeing": count_differences(seen[tracer], reference),
            "seconds": None if math.isnan(answer.seconds) else answer.seconds,
        }
    for tracer, own in seen.items():
        rows[tracer]["differing"] = {
            other: count_differences(own, others)
            for other, others in seen.items()
            if other != tracer
        }
    write_json(
        path,
        {
            "key": key,
            "film": [scene.camera.width, scene.camera.height],
            "rays": len(origins),
            "published": settings.eye_rays.hits,
            "share": settings.eye_rays.share,
            "reference": {"hits": reference.hits},
            "order": list(tracers),
            "tracers": rows,
        },
    )
    return path


def unshaded_settings(settings: Settings, width: int, height: int) -> RenderSettings:
    """Settings to load a scene with: nothing is shaded, so the model that most tracers take."""
    model = "path" if "path" in settings.models else settings.models[0]
    return settings.render(model, width=width, height=height)
