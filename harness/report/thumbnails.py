"""A small picture of each scene: what a newcomer looks at first."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.report import picture
from harness.statistics.metrics import Image
from harness.tables.read import SceneJob
from harness.viewer.links import link_of

SIDE = 128
"""Most pixels of a side; the viewer and report.zip have all of them."""
MODEL = "path"
"""The model that is shown where a scene has it: the others are ways to its picture."""


@dataclass(frozen=True, slots=True)
class Thumbnail:
    """The ground truth of a scene, with a link to it in the viewer."""

    scene: str
    title: str
    model: str
    detail: str
    source: str
    """a PNG as a data URI"""
    width: int
    height: int
    link: str
    tally: Sequence[tuple[str, str, int]]
    """sign, kind and number of the scene's verdicts"""


def data_uri(pixels: NDArray[np.uint8]) -> str:
    """A PNG as a data URI."""
    return "data:image/png;base64," + base64.b64encode(picture.encode_png(pixels)).decode()


def shrink(image: Image, side: int = SIDE) -> Image:
    """Means of squares of pixels, the least squares that leave at most `side` a side: [h, w, 3].

    Rows and columns that do not fill a square are left out.
    """
    block = -(-max(image.shape[:2]) // side)
    height, width = (length // block * block for length in image.shape[:2])
    cut = image[:height, :width].reshape(height // block, block, width // block, block, 3)
    return np.asarray(cut.mean(axis=(1, 3)))


def detail_of(job: SceneJob) -> str:
    """Size of the images, and of the scene."""
    parts = [f"{job.width} × {job.height} pixels"]
    for noun in ("triangles", "spheres"):
        count = job.description.get(noun)
        if count:
            parts.append(f"{count:,} {noun}")
    return ", ".join([*parts, *(["caustic"] if job.caustic else [])])


def make_thumbnail(job: SceneJob, tally: Sequence[tuple[str, str, int]]) -> Thumbnail | None:
    """The truth of a scene in `path`, or in its first model; None if no tracer has images."""
    models = [model for model in job.models if job.tracers(model)]
    if not models:
        return None
    model = MODEL if MODEL in models else models[0]
    mean = job.truth(model).mean
    small = shrink(mean)
    pixels = picture.encode_srgb(small * picture.exposure_of(mean))
    return Thumbnail(
        job.name,
        job.title,
        model,
        detail_of(job),
        data_uri(pixels),
        small.shape[1],
        small.shape[0],
        link_of(job.name, model, job.tracers(model)[0], mode="image"),
        tally,
    )
