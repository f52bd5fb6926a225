"""What the viewer shows of a scene in a model: the mean of every tracer, and its error."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.report.picture import error_range, exposure_of, relative_error
from harness.statistics.metrics import Image, Truth, luminance, make_truth
from harness.tables.read import SceneJob, read_json
from harness.viewer.exposures import Exposures, pin_exposures

TRUTH = "truth"
"""Name of the ground truth among the images."""


@dataclass(frozen=True, slots=True)
class Moments:
    """The mean of independent images, and how well it is known."""

    name: str
    """a tracer, or TRUTH"""
    mean: NDArray[np.float32]
    """[h, w, 3], radiance"""
    sigma: NDArray[np.float32]
    """[h, w], standard error of the luminance of `mean`; NaN of a single image"""
    count: int
    """independent images"""
    spp: int
    """samples a pixel of one image"""


@dataclass(frozen=True, slots=True)
class Limits:
    """Ends of the scales, the same for all images of a panel, so that tracers can be compared."""

    relative: float
    """symmetric"""
    squared: float
    deviation: float
    """radiance"""


@dataclass(frozen=True, slots=True)
class Panel:
    """The images of one scene in one model."""

    scene: str
    title: str
    model: str
    width: int
    height: int
    """of the images as the tracers made them, in pixels"""
    block: int
    """side of the square of pixels whose mean is one pixel here"""
    exposure: float
    """factor of the radiance that is shown at 0 stops"""
    epsilon: float
    """added to the squared truth in denominators"""
    flip: Exposures
    limits: Limits
    images: tuple[Moments, ...]
    """the truth, and the tracers in the order of the registry"""

    @property
    def key(self) -> str:
        """Scene and model, as links name them."""
        return f"{self.scene}/{self.model}"


def block_means(images: Image, block: int) -> Image:
    """Means of squares of pixels: [K, h, w, 3] -> [K, ceil(h / block), ceil(w / block), 3].

    Squares at the right and bottom edges may be smaller.
    """
    if block == 1:
        return images
    height, width = images.shape[1:3]
    rows, columns = np.arange(0, height, block), np.arange(0, width, block)
    sums = np.add.reduceat(np.add.reduceat(images, rows, axis=1), columns, axis=2)
    areas = np.outer(np.diff(np.append(rows, height)), np.diff(np.append(columns, width)))
    return np.asarray(sums / areas[..., None])


def moments_of(name: str, images: Image, spp: int) -> Moments:
    """Mean of images [K, h, w, 3], and the standard error of its luminance."""
    count = images.shape[0]
    light = luminance(images)
    # One image says nothing of its own error.
    sigma = (
        light.std(axis=0, ddof=1) / np.sqrt(count) if count > 1 else np.full_like(light[0], np.nan)
    )
    mean = images.mean(axis=0)
    return Moments(name, mean.astype(np.float32), sigma.astype(np.float32), count, spp)


def _truth_spp(job: SceneJob, model: str) -> int:
    record = job.folder / "truth" / model / "truth.json"
    return int(read_json(record)["spp"]) if record.exists() else 1


def _limits(truth: Truth, images: tuple[Moments, ...]) -> Limits:
    tracers = [image for image in images if image.name != TRUTH]
    means = [image.mean.astype(np.float64) for image in tracers]
    squared = [(truth.weight * (mean - truth.mean) ** 2).mean(axis=-1) for mean in means]
    deviations = [image.sigma * np.sqrt(float(image.count * image.spp)) for image in tracers]
    return Limits(
        error_range([relative_error(mean, truth) for mean in means]),
        error_range(squared),
        error_range([deviation.astype(np.float64) for deviation in deviations]),
    )


def make_panel(job: SceneJob, model: str, side: int | None = None) -> Panel | None:
    """The images of a scene in a model, at most `side` pixels a side; None if no tracer has any.

    Larger images become means of squares of pixels, and their errors those of these means. Raises
    ResultsError for missing or damaged files.
    """
    sets = [(tracer, job.seeds(model, tracer)) for tracer in job.tracers(model)]
    found = [(tracer, images) for tracer, images in sets if images is not None and images.seeds]
    if not found:
        return None
    longer = max(job.width, job.height)
    block = 1 if side is None else max(1, -(-longer // side))
    truth = make_truth(block_means(job.truth(model).batches, block))
    images = (
        moments_of(TRUTH, truth.batches, _truth_spp(job, model)),
        *(
            moments_of(tracer, block_means(images.images.astype(np.float64), block), images.spp)
            for tracer, images in found
        ),
    )
    return Panel(
        scene=job.name,
        title=job.title,
        model=model,
        width=job.width,
        height=job.height,
        block=block,
        exposure=exposure_of(truth.mean),
        epsilon=truth.epsilon,
        flip=pin_exposures(truth.mean),
        limits=_limits(truth, images),
        images=images,
    )


def images_of(job: SceneJob, model: str) -> int:
    """How many images the panel of a scene in a model has, without reading them."""
    folder = job.folder / "seeds" / model
    tracers = [name for name in job.tracers(model) if any((folder / name).glob("seed_*.npy"))]
    return len(tracers) + 1 if tracers else 0


def panels_in_order(
    jobs: list[SceneJob], first: tuple[tuple[str, str], ...] = ()
) -> Iterator[tuple[SceneJob, str]]:
    """Scenes and models: those of `first`, then by the order of models and of scenes.

    A known answer is one colour all over the image, and left out unless `first` names it.
    """
    by_name = {job.name: job for job in jobs}
    models = list(dict.fromkeys(m for job in jobs for m in job.models))
    pictured = [job for job in jobs if not job.description.get("answers")]
    rest = [(job.name, model) for model in models for job in pictured if model in job.models]
    for scene, model in dict.fromkeys([*first, *rest]):
        if scene in by_name and model in by_name[scene].models:
            yield by_name[scene], model
