"""What a run says of one tracer on one scene in one model, small enough to be kept.

A baseline is a folder of these. They hold values by seed, not only means, so that a later run with
the same seeds is compared image by image: where nothing has changed nothing differs, whatever the
noise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.statistics.bias import image_means
from harness.statistics.metrics import Image, Truth, split_error
from harness.statistics.tiles import tile_means
from harness.tables.read import SceneJob
from harness.tables.times import Timed, group_times, headline

SPEED_OVER = "embree"
"""Tracer whose time in the same run everybody's is divided by: a busy machine slows both."""
DIGITS = 7
"""Significant digits that are written: about those of a float32."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Statistics of one tracer's images and times."""

    scene: str
    model: str
    tracer: str
    width: int
    height: int
    tile: int
    spp: int
    seeds: tuple[int, ...]
    means: NDArray[np.float64]
    """[K], mean luminance of each image"""
    variances: NDArray[np.float64]
    """[K], relative variance of one sample a pixel by image; their mean is the variance"""
    tile_mean: NDArray[np.float64]
    """[rows, columns], mean luminance of the tiles over the seeds"""
    tile_variance: NDArray[np.float64]
    """[rows, columns], variance of the tiles' luminance between seeds"""
    log_seconds: NDArray[np.float64]
    """[repeats], logarithm of the time of a sample over that of SPEED_OVER in the same round"""
    timed_on: str
    """processor, threads and GPUs: even a ratio of speeds belongs to them"""

    @property
    def subject(self) -> tuple[str, str, str]:
        """Scene, model and tracer."""
        return self.scene, self.model, self.tracer

    @property
    def frame(self) -> tuple[int, int, int]:
        """What must be equal for tiles to be comparable: width, height and tile."""
        return self.width, self.height, self.tile


def round_ratios(timed: Timed | None, base: Timed | None) -> NDArray[np.float64]:
    """Logarithms of the time of a sample over the base's, round by round: [repeats].

    Tracers take turns, so that the ratio within a round is free of what slows a machine for a
    while. Empty where one of them was not timed, or they are the same.
    """
    if timed is None or base is None or timed.tracer == base.tracer:
        return np.zeros(0)

    def by_round(one: Timed) -> dict[int, float]:
        return {int(row["repeat"]): float(row["seconds"]) / one.spp for row in one.rows}

    own, other = by_round(timed), by_round(base)
    return np.array([np.log(own[k] / other[k]) for k in sorted(own.keys() & other.keys())])


def make_snapshot(
    subject: tuple[str, str, str],
    images: Image,
    truth: Truth,
    *,
    spp: int,
    seeds: tuple[int, ...],
    log_seconds: NDArray[np.float64],
    timed_on: str,
    tile: int,
) -> Snapshot:
    """Summarise finite images [K >= 2, h, w, 3] of one tracer."""
    tiles = tile_means(images, tile)
    scene, model, tracer = subject
    return Snapshot(
        scene,
        model,
        tracer,
        width=images.shape[2],
        height=images.shape[1],
        tile=tile,
        spp=spp,
        seeds=seeds,
        means=image_means(images),
        variances=split_error(images, truth, relative=True).variance_by_image * spp,
        tile_mean=tiles.mean(axis=0),
        tile_variance=tiles.var(axis=0, ddof=1),
        log_seconds=log_seconds,
        timed_on=timed_on,
    )


def machine_of(job: SceneJob) -> str:
    """What the times of a scene were taken on, in a line."""
    machine = job.provenance.get("machine", {})
    gpus = [str(gpu.get("name")) for gpu in machine.get("gpus", [])]
    threads = f"{job.provenance.get('threads')} threads"
    return ", ".join([str(machine.get("processor")), threads, *gpus])


def snapshots_of(job: SceneJob, tile: int) -> list[Snapshot]:
    """Summarise all tracers of a scene that have finite images of at least two seeds.

    Raises ResultsError for missing or damaged files.
    """
    timed, machine = headline(group_times(job)), machine_of(job)
    found = []
    for model in job.models:
        failed = {row.tracer for row in job.absent(model) if row.status == "failed"}
        tracers = [tracer for tracer in job.tracers(model) if tracer not in failed]
        truth = job.truth(model) if tracers else None
        for tracer in tracers:
            images = job.seeds(model, tracer)
            if truth is None or images is None or len(images.seeds) < 2:
                continue
            stack = images.images.astype(np.float64)
            if not np.isfinite(stack).all():
                continue
            ratios = round_ratios(timed.get((model, tracer)), timed.get((model, SPEED_OVER)))
            found.append(
                make_snapshot(
                    (job.name, model, tracer),
                    stack,
                    truth,
                    spp=images.spp,
                    seeds=images.seeds,
                    log_seconds=ratios,
                    timed_on=machine,
                    tile=tile,
                )
            )
    return found


ARRAYS = ("means", "variances", "tile_mean", "tile_variance", "log_seconds")


def to_record(snapshot: Snapshot) -> dict[str, Any]:
    """A snapshot as JSON values, rounded to DIGITS significant digits."""

    def rounded(values: Any) -> Any:
        if isinstance(values, list):
            return [rounded(value) for value in values]
        return float(f"{values:.{DIGITS}g}")

    record: dict[str, Any] = {
        name: getattr(snapshot, name) for name in ("model", "tracer", "width", "height", "tile")
    }
    record |= {"spp": snapshot.spp, "seeds": list(snapshot.seeds), "timed_on": snapshot.timed_on}
    return record | {name: rounded(getattr(snapshot, name).tolist()) for name in ARRAYS}


def from_record(scene: str, record: Mapping[str, Any]) -> Snapshot:
    """Read back what `to_record` made; raises KeyError or TypeError for anything else."""
    values = dict(record)
    arrays = {name: np.array(values.pop(name), dtype=np.float64) for name in ARRAYS}
    return Snapshot(scene=scene, **(values | {"seeds": tuple(values["seeds"])}), **arrays)
