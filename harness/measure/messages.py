"""What a parent and its worker processes say to each other."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harness.scene import RenderSettings
from harness.tracers.base import RenderResult
from harness.tracers.rays import RayHits, Structure, Visits, Way


@dataclass(frozen=True, slots=True)
class Probe:
    """Ask whether the tracer can run on this machine. Answered by `Ready` or `Refused`."""


@dataclass(frozen=True, slots=True)
class Load:
    """Make a scene ready. Answered by `Loaded` or `Refused`."""

    scene_path: Path
    settings: RenderSettings


@dataclass(frozen=True, slots=True)
class Render:
    """Render the loaded scene once. Answered by a `RenderResult`."""

    seed: int
    spp: int
    engine: str = "depth_first"
    options: Mapping[str, object] = field(default_factory=dict)
    count_rays: bool = False


@dataclass(frozen=True, slots=True)
class Trace:
    """Trace rays through the loaded scene. Answered by `RayHits` or `Refused`."""

    origins: NDArray[np.float32]
    directions: NDArray[np.float32]
    t_min: float | NDArray[np.float32] = 0.0
    t_max: float | NDArray[np.float32] = np.inf
    any_hit: bool = False


@dataclass(frozen=True, slots=True)
class Take:
    """Read a class of rays, for any number of replays. Answered by `Taken` or `Refused`.

    file, rays: as of `Replay`. most: of all the replays, see there.
    """

    file: Path
    rays: str
    most: tuple[int | None, ...]


@dataclass(frozen=True, slots=True)
class Taken:
    """The rays are there."""


@dataclass(frozen=True, slots=True)
class Replay:
    """Trace a class of rays of a file. Answered by `Replayed` or `Refused`.

    file: of `harness.rays.store`. most: trace so many of the rays, at even distances, where there
    are more. hits: send back what was hit, and count what the traversal looks at. energy: read the
    GPU's counter around all repeats.
    """

    file: Path
    rays: str
    any_hit: bool
    way: Way
    most: int | None = None
    repeats: int = 1
    hits: bool = False
    energy: bool = False


@dataclass(frozen=True, slots=True)
class Replayed:
    """What a replay gave.

    times: seconds of each repeat. rays: how many were traced. t, primitive: as of `RayHits`, where
    they were asked for. peak_bytes: most memory that the tracer's process has held so far. joules:
    energy of a repeat, or why it is not known.
    """

    times: tuple[float, ...]
    rays: int
    t: NDArray[np.float32] | None
    primitive: NDArray[np.uint32] | None
    visits: Visits | None
    structure: Structure | None
    peak_bytes: int
    joules: float | str


@dataclass(frozen=True, slots=True)
class Ready:
    """The tracer can run; what it says of itself."""

    models: frozenset[str]
    engines: tuple[str, ...]
    precision: str
    warm_ups: int
    ways: tuple[Way, ...]
    on_gpu: bool
    knobs: frozenset[str]


@dataclass(frozen=True, slots=True)
class Loaded:
    """The scene is ready: split times and sizes, named with their units, and hashes."""

    times: dict[str, float]
    hashes: dict[str, str]


@dataclass(frozen=True, slots=True)
class Refused:
    """The machine lacks something, or the tracer does not support the scene."""

    reason: str


@dataclass(frozen=True, slots=True)
class Failed:
    """The tracer raised; its process is about to end."""

    message: str


Request = Probe | Load | Render | Trace | Take | Replay
Answer = Ready | Loaded | Refused | Failed | RenderResult | RayHits | Taken | Replayed
