"""Every render of the study of packets on one scene in one model."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from harness.measure.files import key_of
from harness.measure.messages import Render

Case = dict[str, object]

QUEUES = ("packets", "streams", "layers", "wavefront")
"""Engines that take rays in packets of a size that is set, in the ladder's order."""
ORDERED = frozenset({"packets", "streams"})
"""Engines that can take them from either end."""
SEED = 0


@dataclass(frozen=True, slots=True)
class StudyRender:
    """A render of the study, and how often it is timed."""

    engine: str
    case: Case = field(hash=False)
    """what is swept, as the tables name it"""
    options: Case = field(hash=False)
    """the engine's settings"""
    width: int
    """of the square image"""
    spp: int
    repeats: int
    """0: only its queue is looked at"""
    with_joules: bool = False

    @property
    def request(self) -> Render:
        """What a tracer is asked for."""
        return Render(seed=SEED, spp=self.spp, engine=self.engine, options=self.options)

    @property
    def samples(self) -> int:
        """Camera samples of the whole render."""
        return self.width * self.width * self.spp

    def key(self, subject: str) -> str:
        """Equal for renders of the same row."""
        request = asdict(self.request)
        parts = {"subject": subject, "request": request, "case": self.case, "width": self.width}
        return key_of(parts)


@dataclass(frozen=True, slots=True)
class StudyPlan:
    """What decides the renders of one tracer: a part of the run's settings."""

    settings: Mapping[str, Any]
    engines: Sequence[str]
    sizes: Sequence[int]
    rays_per_sample: float
    """rays that a queue carries: camera, bounce and ambient"""

    @property
    def on_device(self) -> bool:
        """Whether there is a GPU, whose memory may be allocated for each packet."""
        return "streams" in self.engines

    @property
    def _compared(self) -> list[int]:
        """Sizes at which ratios are taken, with more repeats."""
        return [size for size in self.settings["elsewhere"]["sizes"] if size in self.sizes]

    def renders(self) -> list[StudyRender]:
        """The sweep of launches, what it is compared with, and the queues over the samples."""
        found: list[StudyRender] = []
        for engine in self.engines:
            largest = self.settings["largest"].get(engine, max(self.sizes))
            for size in (size for size in self.sizes if size <= largest):
                found += self._launches(engine, size)
        return found + self._memory()

    def _launches(self, engine: str, size: int) -> list[StudyRender]:
        compared = size in self._compared
        repeats = self.settings["price_repeats" if compared else "repeats"]
        cases: list[Case] = [{}]
        if engine in ORDERED:
            cases = [{"order": order} for order in self.settings["orders"]]
        if engine == "packets" and self.on_device:
            kinds = ("per_packet", "once")
            cases = [{**case, "allocation": kind} for kind in kinds for case in cases]
        # The paper's film, where its price is asked for: once an engine.
        if self.on_device and compared and size == max(self._compared):
            cases.append({**cases[-1], "film": "float_atomic"})
        joules = compared and self.settings["joules_seconds"] > 0 and self.on_device
        if engine in QUEUES:
            width, spp = self._filled(engine, size)
            queue = {"queue_bytes": self.settings["queue_bytes"]}
            return [
                StudyRender(
                    *(engine, {"packet": size, **case}, {"packet": size, **case, **queue}),
                    *(width, spp, repeats, joules and "film" not in case),
                )
                for case in cases
            ]
        # A launch of these is an image: small ones are short, and have room for more repeats.
        width = min(self.settings["width"], 2 ** (int(math.log2(size)) // 2))
        spp = max(1, round(size / width**2))
        return [
            StudyRender(
                *(engine, {"samples": width * width * spp, **case}, {**case}),
                *(width, spp, repeats if compared else 2 * repeats, joules and "film" not in case),
            )
            for case in cases
        ]

    def _filled(self, engine: str, size: int) -> tuple[int, int]:
        """An image with rays for several full launches, and some however small they are."""
        launches = self.settings["engine_launches"].get(engine, self.settings["launches"])
        rays = max(launches * size, self.settings["least_rays"])
        width = self.settings["width"]
        return width, max(1, math.ceil(rays / (self.rays_per_sample * width**2)))

    def _memory(self) -> list[StudyRender]:
        """Queues over the samples of an image: layers of all of it against packets of one size."""
        width = self.settings["width"]
        packet = self.settings["memory"]["packet"]
        found = []
        for spp in self.settings["memory"]["spp"]:
            samples = width * width * spp
            kinds: list[tuple[str, Case]] = [("layers", {"packet": samples})]
            kinds += [("packets", {"packet": packet, "order": o}) for o in self.settings["orders"]]
            for engine, case in kinds:
                if engine in self.engines:
                    options = {**case, "queue_bytes": self.settings["queue_bytes"]}
                    where = {**case, "samples": samples}
                    found.append(StudyRender(engine, where, options, width, spp, 0))
        return found
