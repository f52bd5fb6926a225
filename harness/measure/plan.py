"""Every render of a scene's job, fixed before the first of them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import zip_longest
from pathlib import Path
from typing import TypeVar

from harness.measure.config import CONVERGENCE_SEED, Config
from harness.measure.files import key_of
from harness.measure.messages import Render
from harness.measure.provenance import tracer_code
from harness.scene import RenderSettings, Scene

Planned = TypeVar("Planned")
Case = dict[str, object]

QUEUES = frozenset({"packets", "streams", "layers", "wavefront"})
"""Engines that take rays in packets of a size that is set."""


@dataclass(frozen=True, slots=True)
class Subject:
    """One tracer on one scene in one model, and a hash of all that its images depend on."""

    scene: str
    tracer: str
    model: str
    key: str


@dataclass(frozen=True, slots=True)
class PlannedImage:
    """An image to be kept. `stem` is its file without an ending, relative to the scene's folder."""

    subject: Subject
    stem: Path
    request: Render

    @property
    def key(self) -> str:
        """Equal for equal images."""
        return key_of({"subject": self.subject.key, "request": asdict(self.request)})


@dataclass(frozen=True, slots=True)
class Untaken:
    """A turn of a knob that a tracer has not, and why."""

    subject: Subject
    case: Case
    reason: str


@dataclass(frozen=True, slots=True)
class PlannedTime:
    """A render to be timed."""

    subject: Subject
    request: Render
    repeat: int

    @property
    def key(self) -> str:
        """Equal for repeats of the same row of timing.json."""
        return key_of(
            {
                "subject": self.subject.key,
                "request": asdict(self.request),
                "repeat": self.repeat,
            }
        )


def subject_of(
    scene: Scene, tracer: str, settings: RenderSettings, threads: int, *, recentre: bool
) -> Subject:
    """Name a tracer on a scene, with the hash of scene, settings, code and number of threads."""
    key = key_of(
        {
            "scene": scene.sha256,
            "recentre": recentre,
            "tracer": tracer,
            "settings": asdict(settings),
            "code": tracer_code(tracer),
            "threads": threads,
        }
    )
    return Subject(scene=scene.name, tracer=tracer, model=settings.model, key=key)


def plan_seeds(config: Config, subject: Subject) -> list[PlannedImage]:
    """List the independent images of a tracer."""
    spp = config.seeds_spp(subject.scene, subject.model, subject.tracer)
    folder = Path("seeds") / subject.model / subject.tracer
    return [
        PlannedImage(subject, folder / f"seed_{seed:03d}", Render(seed=seed, spp=spp))
        for seed in range(config["seeds"]["count"])
    ]


def plan_convergence(config: Config, subject: Subject) -> list[PlannedImage]:
    """List the images at doubling sample counts; the seeds of one count are those of no other."""
    if not config.converges(subject.scene, subject.model, subject.tracer):
        return []
    folder = Path("convergence") / subject.model / subject.tracer
    return [
        PlannedImage(
            subject,
            folder / f"spp_{2**doubling}_seed_{index}",
            Render(seed=CONVERGENCE_SEED + 1000 * doubling + index, spp=2**doubling),
        )
        for doubling in range(config["convergence"]["doublings"] + 1)
        for index in range(config.convergence_seeds(subject.scene, doubling))
    ]


def plan_timing(config: Config, subject: Subject) -> list[PlannedTime]:
    """List the timed renders of a tracer's own engine: one seed, many repeats."""
    spp = config.timing_spp(subject.model, subject.tracer)
    return [
        PlannedTime(subject, Render(seed=0, spp=spp), repeat)
        for repeat in range(config["timing"]["repeats"])
    ]


def plan_packets(config: Config, subject: Subject, engines: Sequence[str]) -> list[PlannedTime]:
    """List the sweep of packet sizes: every size and order once before any of them again."""
    sweep = config["packets"]
    swept = subject.scene in sweep["scenes"] and subject.model in sweep["models"]
    if "packets" not in engines or not swept:
        return []
    cases = [
        {"packet": size, "order": order}
        for size in config.packet_sizes(subject.tracer)
        for order in sweep["orders"]
    ]
    return [
        PlannedTime(
            subject, Render(seed=0, spp=sweep["spp"], engine="packets", options=case), repeat
        )
        for repeat in range(sweep["repeats"])
        for case in cases
    ]


def _engine_cases(engine: str, engines: Sequence[str], packets: Sequence[int]) -> list[Case]:
    """What one engine is swept with: its packet sizes, and where device memory is allocated."""
    sizes: list[Case] = [{"packet": size} for size in packets] if engine in QUEUES else [{}]
    # Where there are streams there is a device, whose memory the paper allocates for each packet.
    if engine == "packets" and "streams" in engines:
        kinds: list[Case] = [{"allocation": "per_packet"}, {"allocation": "once"}]
    else:
        kinds = [{}]
    # The case of an engine is never empty, for times without one are a tracer's own.
    return [{"accumulation": "flat", **size, **kind} for kind in kinds for size in sizes]


def plan_engines(config: Config, subject: Subject, engines: Sequence[str]) -> list[PlannedTime]:
    """List the sweep of engines: each of them once before any of them again."""
    sweep = config["engines"]
    swept = subject.scene in sweep["scenes"] and subject.model in sweep["models"]
    if len(engines) < 2 or not swept:
        return []
    requests = [
        Render(seed=0, spp=sweep["spp"], engine=engine, options=case)
        for engine in engines
        for case in _engine_cases(engine, engines, sweep["packets"])
    ]
    return [
        PlannedTime(subject, request, repeat)
        for repeat in range(sweep["repeats"])
        for request in requests
    ]


def knob_cases(config: Config, settings: RenderSettings) -> list[Case]:
    """List the turns of the knobs of one model, each with all that it differs by from the scene.

    In `path` the exact one is first: no depth limit but one that leaves nothing out. Depth limits
    are swept, the scene's own among them, and everything else without a limit.
    """
    sweep = config["knobs"]
    if settings.model == "haste":
        return [
            {"ambient_samples": ambient, "light_samples": light}
            for light in sweep["light_samples"]
            for ambient in sweep["ambient_samples"]
        ]
    if settings.model != "path":
        return []
    exact: Case = {"max_depth": sweep["exact_depth"]}
    depths = sorted({*sweep["max_depth"], settings.max_depth} - {sweep["exact_depth"]})
    others = [{key: value} for key in ("rr_depth", "clamp", "film") for value in sweep[key]]
    return [exact, *({"max_depth": depth} for depth in depths), *(exact | own for own in others)]


def plan_knobs(
    config: Config, subject: Subject, settings: RenderSettings, knobs: Iterable[str]
) -> tuple[list[PlannedImage], list[Untaken]]:
    """List the sweep of the knobs: every turn once before any of them again.

    The seeds are the same ones for all, so that what a turn changes is seen beside equal noise.
    """
    sweep = config["knobs"]
    if subject.scene not in sweep["scenes"] or subject.tracer not in sweep["tracers"]:
        return [], []
    images, untaken = [], []
    cases = knob_cases(config, settings)
    for case in cases:
        lacking = sorted(case.keys() - set(knobs))
        if lacking:
            reason = f"{subject.tracer} has no choice of {', '.join(lacking)}"
            untaken.append(Untaken(subject, case, reason))
    refused = [other.case for other in untaken]
    if not cases:
        return [], []
    spp = config.knobs_spp(subject.model, subject.tracer)
    folder = Path("knobs") / subject.model / subject.tracer
    for seed in range(sweep["seeds"]):
        for case in cases:
            if case in refused:
                continue
            name = "_".join(f"{key}-{value}" for key, value in sorted(case.items()))
            request = Render(seed=seed, spp=spp, options=case)
            images.append(PlannedImage(subject, folder / name / f"seed_{seed:03d}", request))
    return images, untaken


def in_turn(plans: Sequence[Sequence[Planned]]) -> Iterator[Planned]:
    """Take one from each plan, then the next from each: A B C A B C, until all are used up."""
    for together in zip_longest(*plans):
        yield from (one for one in together if one is not None)
