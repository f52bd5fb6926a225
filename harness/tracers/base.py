"""The interface that every tracer under test implements."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.scene import RenderSettings
from harness.statistics.work_spans import WorkSpan
from harness.tracers.rays import Held, Query, RayHits, Rays, Structure, Way, make_rays

NO_OPTIONS: Mapping[str, object] = MappingProxyType({})


class UnsupportedError(Exception):
    """A tracer cannot render this scene or model, and says why: a skipped row, not a defect."""


@dataclass(frozen=True, slots=True)
class RayCounts:
    """Live rays traced in one render, by class; dead or padded lanes do not count."""

    camera: int
    shadow: int
    ambient: int
    bounce: int

    @property
    def total(self) -> int:
        """All rays."""
        return self.camera + self.shadow + self.ambient + self.bounce


@dataclass(frozen=True, slots=True)
class RenderResult:
    """What one render gave.

    Attributes
    ----------
    image
        float64 [height, width, 3], linear RGB radiance, the mean over the samples of a pixel.
    seconds
        Wall-clock time of tracing alone, [s]: no loading, building, compiling or copying of images.
    rays
        Counts of live rays, where they were asked for and the tracer can count.
    film_sha256
        Hash of the film's integers, where the tracer promises them bit for bit.
    extras
        Further numbers, named with their units (``peak_queue_bytes``).
    spans
        What the time went into, where the option ``record_spans`` asks for it.
    """

    image: NDArray[np.float64]
    seconds: float
    rays: RayCounts | None = None
    film_sha256: str | None = None
    extras: dict[str, float] = field(default_factory=dict)
    spans: tuple[WorkSpan, ...] = ()


class Tracer(ABC):
    """One tracer, living in a process of its own.

    A subclass is importable on every machine: what it needs is imported in `unavailable`, `load`
    and `render`, never at the top of its module.

    Attributes
    ----------
    name
        The key of the registry.
    models
        Lighting models in which it is compared with others.
    engines
        How it can schedule its rays; the first is the one of images and of the headline's times.
    precision
        The arithmetic it promises.
    warm_ups
        Untimed renders before the first timed one.
    on_gpu
        Whether it traces on a GPU.
    knobs
        Settings that a single render may have otherwise than the loaded scene: `options` of
        `render`.
    """

    name: ClassVar[str]
    models: ClassVar[frozenset[str]]
    engines: ClassVar[tuple[str, ...]] = ("depth_first",)
    precision: ClassVar[str]
    warm_ups: ClassVar[int] = 1
    on_gpu: ClassVar[bool] = False
    knobs: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.hashes: dict[str, str] = {}
        """Hashes of what `load` made, by name (``bvh_sha256``)."""

    @classmethod
    @abstractmethod
    def unavailable(cls) -> str | None:
        """Why this machine cannot run the tracer, and what would mend that; None if it can."""

    @abstractmethod
    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        """Make a scene ready to render, replacing the one before.

        Returns
        -------
        dict
            Split times and sizes, named with their units: ``load_seconds``, ``build_seconds``,
            ``upload_seconds``, ``compile_seconds``, ``bvh_bytes``.

        Raises
        ------
        UnsupportedError
            The tracer cannot render this scene or model.
        """

    @abstractmethod
    def render(
        self,
        seed: int,
        spp: int,
        *,
        engine: str = "depth_first",
        options: Mapping[str, object] = NO_OPTIONS,
        count_rays: bool = False,
    ) -> RenderResult:
        """Render the loaded scene once.

        Parameters
        ----------
        seed
            Seed of the generator; renders of different seeds are independent.
        spp
            Samples a pixel.
        engine
            One of `engines`.
        options
            The engine's settings: ``packet``, ``order``, ``allocation``, ``block``; and any of
            `knobs`.
        count_rays
            Count rays, which may cost time; never set in a timed render.
        """

    def trace(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        t_min: float | NDArray[np.float32] = 0.0,
        t_max: float | NDArray[np.float32] = np.inf,
        *,
        any_hit: bool = False,
        way: Way | None = None,
        repeats: int = 1,
        count: bool = False,
    ) -> RayHits:
        """Trace rays through the loaded scene; nothing is shaded.

        Parameters
        ----------
        origins, directions
            float32 [N, 3]; directions need not have unit length.
        t_min, t_max
            Hits count within (t_min, t_max], in units of the direction: one number for all rays, or
            float32 [N].
        any_hit
            Ask only whether there is a hit, as for a shadow ray, not where the closest one is.
        way
            One of `ways`; the first of them where None. It changes no hit.
        repeats
            How often to trace the same rays.
        count
            Count what the traversal looks at, which takes time; never set in a timed call.

        Raises
        ------
        ValueError
            An array has the wrong shape or type, or a ray makes no sense; names it.
        UnsupportedError
            The tracer has no such query, or no such way.
        """
        rays = self.hold(make_rays(origins, directions, t_min, t_max))
        way = way or self.ways()[0]
        return self.replay(rays, way, Query(any_hit=any_hit, repeats=repeats, count=count))

    @classmethod
    def ways(cls) -> tuple[Way, ...]:
        """In which ways it traces rays: the first is that of its images."""
        return (Way("", cls.precision),)

    def structure(self, way: Way) -> Structure | None:
        """The acceleration structure of the loaded scene; None where it cannot be told."""
        del way
        return None

    def hold(self, rays: Rays) -> Held:
        """Take over rays that have been checked, as it wants them: they are handed over once."""
        return rays

    def replay(self, rays: Held, way: Way, query: Query) -> RayHits:
        """Trace rays that `hold` has taken; what a tracer implements if it has such a query.

        Raises UnsupportedError like `trace`.
        """
        del rays, way, query
        raise UnsupportedError(f"{self.name} traces no rays but those of its own images")
