"""Tracers for the tests of the machinery: they trace nothing, and misbehave when told to."""

import os
import signal
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from harness.scene import RenderSettings
from harness.tracers.base import NO_OPTIONS, RayCounts, RenderResult, Tracer, UnsupportedError
from harness.tracers.rays import NONE, Held, Query, RayHits, Structure, Visits, Way

LOG_VARIABLE = "FAKE_TRACER_LOG"


def log(text: str) -> None:
    """Append a line to the file that the test reads."""
    with Path(os.environ[LOG_VARIABLE]).open("a") as file:
        file.write(text + "\n")


class SteadyA(Tracer):
    """Renders its seed as a grey image."""

    name: ClassVar[str] = "A"
    models: ClassVar[frozenset[str]] = frozenset({"path", "whitted"})
    precision: ClassVar[str] = "watertight"

    @classmethod
    def unavailable(cls) -> str | None:
        return None

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        assert scene_path.exists()
        log(f"{self.name} load {settings.model}")
        self.shape = (settings.height, settings.width, 3)
        self.hashes = {"bvh_sha256": "b" * 64}
        return {"load_seconds": 0.5, "build_seconds": 0.25}

    def render(
        self,
        seed: int,
        spp: int,
        *,
        engine: str = "depth_first",
        options: Mapping[str, object] = NO_OPTIONS,
        count_rays: bool = False,
    ) -> RenderResult:
        case = " ".join(f"{key}={value}" for key, value in options.items())
        counted = "counted" if count_rays else "timed"
        log(f"{self.name} {engine} seed={seed} spp={spp} {counted} {case}".rstrip())
        rays = RayCounts(camera=spp, shadow=2 * spp, ambient=0, bounce=0) if count_rays else None
        image = np.full(self.shape, float(seed))
        return RenderResult(image, 0.001 * spp, rays, f"film {seed} {spp}", {"non_finite": 0.0})


class SteadyB(SteadyA):
    name: ClassVar[str] = "B"
    warm_ups: ClassVar[int] = 2


class Packets(SteadyA):
    name: ClassVar[str] = "P"
    engines: ClassVar[tuple[str, ...]] = ("depth_first", "packets")


class Turning(SteadyA):
    name: ClassVar[str] = "T"
    knobs: ClassVar[frozenset[str]] = frozenset({"max_depth", "rr_depth"})


class Missing(SteadyA):
    name: ClassVar[str] = "missing"

    @classmethod
    def unavailable(cls) -> str | None:
        return "no such machine: apt-get install one"


class Picky(SteadyA):
    name: ClassVar[str] = "picky"

    def load(self, *_: object) -> dict[str, float]:
        raise UnsupportedError("the scene has a sphere")


class Aborting(SteadyA):
    """Ends its process from within, as a broken library does, at seed 2."""

    name: ClassVar[str] = "aborting"

    def render(self, seed: int, spp: int, **rest: object) -> RenderResult:
        if seed == 2:
            os.write(sys.stderr.fileno(), b"kernel fault at pixel (3, 4)\n")
            os.abort()
        return super().render(seed, spp, **rest)


class Raising(SteadyA):
    name: ClassVar[str] = "raising"

    def render(self, *_: object, **__: object) -> RenderResult:
        raise ValueError("film overflow at pixel (5, 6)")


class DyingOfRays(SteadyA):
    """Renders, and ends its process when it is asked for rays."""

    name: ClassVar[str] = "dying"

    def trace(self, *_: object, **__: object) -> RayHits:
        os.abort()


class Sleeping(SteadyA):
    name: ClassVar[str] = "sleeping"

    def render(self, seed: int, spp: int, **rest: object) -> RenderResult:
        time.sleep(60.0)
        return super().render(seed, spp, **rest)


class KillsItsParent(SteadyA):
    """Stands for a run that is killed while it renders seed 2."""

    name: ClassVar[str] = "killer"

    def render(self, seed: int, spp: int, **rest: object) -> RenderResult:
        if seed == 2 and os.environ.get("FAKE_KILL"):
            os.kill(os.getppid(), signal.SIGKILL)
            time.sleep(0.5)
        return super().render(seed, spp, **rest)


class Replaying(SteadyA):
    """Sees nothing, and takes a millisecond longer each time."""

    name: ClassVar[str] = "replaying"

    @classmethod
    def ways(cls) -> tuple[Way, ...]:
        return (Way("intersect1", cls.precision), Way("intersect8", cls.precision))

    def structure(self, way: Way) -> Structure:
        del way
        return Structure(build_seconds=0.25, size=640.0)

    def replay(self, rays: Held, way: Way, query: Query) -> RayHits:
        if way.traversal == "intersect8":
            raise UnsupportedError("no packets here")
        kind, counted = "any" if query.any_hit else "closest", " counted" if query.count else ""
        log(f"{self.name} {len(rays)} {kind} x{query.repeats}{counted}")
        self.seconds = getattr(self, "seconds", 0.0) + 0.001
        nowhere = np.full(len(rays) if query.hits else 0, NONE)
        times = (9.0,) * (query.repeats - 1) + (self.seconds,)
        visits = Visits(5.0, 2.0) if query.count else None
        return RayHits(np.full(len(nowhere), np.inf, np.float32), nowhere, nowhere, times, visits)


class ReplayingToo(Replaying):
    name: ClassVar[str] = "too"


class DyingWhenTimed(Replaying):
    """Ends its process after the rays have been looked at and warmed up."""

    name: ClassVar[str] = "dying late"

    def replay(self, rays: Held, way: Way, query: Query) -> RayHits:
        if query.repeats == 2:
            os.abort()
        return super().replay(rays, way, query)


class FailsAtLargePackets(Packets):
    """Has no room for packets of 64 rays."""

    name: ClassVar[str] = "failing"

    def render(self, seed: int, spp: int, **rest: Any) -> RenderResult:
        if rest.get("options", {}).get("packet") == 64:
            raise MemoryError("no room for 64 rays")
        return super().render(seed, spp, **rest)
