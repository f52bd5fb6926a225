"""Measurements that come from eye rays: counts beside the published one, and disagreement."""

from __future__ import annotations

import math

from harness.eye_rays import EyeRayVerdict, NoEyeRays, judge_eye_rays
from harness.statistics.intervals import Interval
from harness.tables.images import PRECISIONS, exact
from harness.tables.read import SceneJob, read_json
from harness.tables.schema import Recorder, Subject

RECORD = "eye_rays.json"
ENGINE = "replay"
MODEL = "none"
"""Model of what is not shaded."""


def eye_rays_of(job: SceneJob) -> list[EyeRayVerdict | NoEyeRays]:
    """What is said of each tracer's eye rays on a scene; empty where none were asked for.

    Raises ResultsError for a damaged record.
    """
    path = job.folder / RECORD
    return list(judge_eye_rays(job.name, read_json(path))) if path.exists() else []


def record_eye_rays(recorder: Recorder, job: SceneJob) -> None:
    """Record the count of every tracer, the published one, and the rays on which tracers differ."""
    for row in eye_rays_of(job):
        precision = PRECISIONS.get(row.tracer, "native")
        subject = Subject(job.run, job.name, row.tracer, MODEL, ENGINE, precision)
        if isinstance(row, NoEyeRays):
            nothing = Interval(math.nan, math.nan, math.nan, 0)
            recorder.measure(subject, "eye_rays_hit", nothing, status=row.status, note=row.reason)
            continue
        recorder.measure(subject, "eye_rays_hit", exact(row.hits, row.rays))
        recorder.measure(subject, "eye_rays_published", exact(row.published, row.rays))
        apart = exact(row.ppm(row.disagreeing), row.rays)
        recorder.measure(subject, "eye_rays_disagreement_ppm", apart)
        for other, count in row.differing.items():
            between = exact(row.ppm(count), row.rays)
            recorder.measure(subject, "eye_rays_disagreement_ppm", between, {"to": other})
