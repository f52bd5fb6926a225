"""Measurements of scenes whose radiance is known: the answer, and how far an image is from it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harness.statistics.bias import image_means
from harness.statistics.intervals import Interval, t_interval
from harness.statistics.metrics import luminance
from harness.tables.images import subject_of
from harness.tables.read import ResultsError, SceneJob, model_order, tracer_order
from harness.tables.schema import Recorder

LEVEL = 0.99
"""Confidence level of the interval of an error."""
TRUTH = "truth"
"""Stands for a tracer where the ground truth is measured: it must know the answer, too."""


def answers_of(job: SceneJob) -> dict[str, float]:
    """Luminance of a job's answers by model, in the order of the tables; may be empty."""
    answers = job.description.get("answers")
    if answers is None and job.description.get("settings", {}).get("answer"):
        raise ResultsError(f"{job.folder / 'scene.json'}: the scene's known answers are missing")
    known = answers or {}
    return {
        model: float(luminance(np.array(known[model]))) for model in sorted(known, key=model_order)
    }


def measured_radiance(job: SceneJob, model: str) -> dict[str, NDArray[np.float64]]:
    """Mean luminance of each image of a model: the truth's batches, then the tracers' seeds.

    A tracer is measured also where there is no truth: an answer needs none.
    """
    folders = (job.folder / "seeds" / model).glob("*")
    tracers = sorted((folder.name for folder in folders), key=tracer_order)
    failed = {row.tracer for row in job.absent(model) if row.status == "failed"}
    found = {}
    if tracers and model not in job.untrue:
        found[TRUTH] = image_means(job.truth(model).batches)
    for tracer in tracers:
        images = job.seeds(model, tracer)
        if tracer not in failed and images is not None and images.seeds:
            found[tracer] = image_means(images.images.astype(np.float64))
    return found


def relative_error(means: NDArray[np.float64], expected: float) -> Interval:
    """Mean of independent image means [K] over the known radiance, less 1, with Student's t."""
    return t_interval(means / expected - 1.0, LEVEL)


def record_answers(recorder: Recorder, job: SceneJob) -> None:
    """Record the known radiance of a scene, and the error of the truth and of every tracer."""
    for model, expected in answers_of(job).items():
        for tracer, means in measured_radiance(job, model).items():
            subject = subject_of(job, model, tracer)
            known = Interval(expected, math.nan, math.nan, 1)
            recorder.measure(subject, "answer", known)
            if np.isfinite(means).all():
                error = relative_error(means, expected)
                recorder.measure(subject, "answer_error", error, {"level": LEVEL})
