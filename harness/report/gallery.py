"""Pictures of the report: truth, tracers and error maps of one scene in one model."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.gate import Judgement
from harness.report import picture
from harness.report.numbers import percent, percent_bounds
from harness.tables.read import SceneJob


@dataclass(frozen=True, slots=True)
class Outline:
    """A rejected tile, in per cent of the image's width and height."""

    left: float
    top: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Shot:
    """One tracer's image and error map, as data URIs."""

    tracer: str
    image: str
    error: str
    caption: str
    bias: str
    outlines: Sequence[Outline]


@dataclass(frozen=True, slots=True)
class Strip:
    """The pictures of one scene in one model."""

    model: str
    truth: str
    truth_caption: str
    shots: Sequence[Shot]
    limit: str
    """end of the scale of the error maps, in per cent"""
    ramp: str
    """the scale itself, as a data URI"""


def data_uri(pixels: NDArray[np.uint8]) -> str:
    """A PNG as a data URI."""
    return "data:image/png;base64," + base64.b64encode(picture.encode_png(pixels)).decode()


def _outlines(judgement: Judgement | None, job: SceneJob, tile: int) -> list[Outline]:
    if judgement is None or judgement.tiles is None:
        return []
    boxes = []
    for row, column in np.argwhere(judgement.tiles.p < judgement.tile_level):
        right = min((column + 1) * tile, job.width)
        bottom = min((row + 1) * tile, job.height)
        boxes.append(
            Outline(
                100.0 * column * tile / job.width,
                100.0 * row * tile / job.height,
                100.0 * (right - column * tile) / job.width,
                100.0 * (bottom - row * tile) / job.height,
            )
        )
    return boxes


def make_strip(
    job: SceneJob, model: str, judgements: Sequence[Judgement], tile: int
) -> Strip | None:
    """The pictures of a scene in a model, or None if no tracer has images of it."""
    sets = {tracer: job.seeds(model, tracer) for tracer in job.tracers(model)}
    means = {
        tracer: found.images.astype(np.float64).mean(axis=0)
        for tracer, found in sets.items()
        if found is not None and found.seeds
    }
    if not means:
        return None
    truth = job.truth(model)
    exposure = picture.exposure_of(truth.mean)
    errors = {tracer: picture.relative_error(image, truth) for tracer, image in means.items()}
    limit = picture.error_range(list(errors.values()))
    verdicts = {
        row.tracer: row for row in judgements if (row.scene, row.model) == (job.name, model)
    }
    shots = []
    for tracer, image in means.items():
        found = sets[tracer]
        judgement = verdicts.get(tracer)
        caption = f"{len(found.seeds)} × {found.spp} samples a pixel" if found else ""
        bias = ""
        if judgement is not None and judgement.bias is not None:
            interval = judgement.bias.bias
            bias = f"bias {percent(interval.value)} % {percent_bounds(interval)}"
        shots.append(
            Shot(
                tracer,
                data_uri(picture.encode_srgb(image * exposure)),
                data_uri(picture.colour_errors(errors[tracer], limit)),
                caption,
                bias,
                _outlines(judgement, job, tile),
            )
        )
    ramp = picture.colour_errors(np.linspace(-1.0, 1.0, 129)[None, :], 1.0)
    return Strip(
        model,
        data_uri(picture.encode_srgb(truth.mean * exposure)),
        f"{truth.batches.shape[0]} batches",
        shots,
        f"{100.0 * limit:g}",
        data_uri(ramp),
    )
