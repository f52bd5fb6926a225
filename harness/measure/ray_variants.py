"""What takes part in the benchmark of rays, and what comes of it: the rows of a class."""

from dataclasses import asdict, dataclass, field
from typing import Any

from harness.measure.crew import NoHits
from harness.measure.messages import Replayed
from harness.rays.agreement import Sight
from harness.tracers.rays import Structure, Way


@dataclass(slots=True)
class Variant:
    """One tracer in one way, and what came of it for one class of rays."""

    tracer: str
    way: Way
    most: int | None = None
    status: str = "ok"
    reason: str = ""
    rays: int = 0
    times: list[float] = field(default_factory=list)
    first: Replayed | None = None
    """of the repeat whose hits are compared"""
    sight: Sight | None = None
    joules: float | None = None
    energy_reason: str = ""

    def end(self, why: NoHits) -> None:
        """Note that there is no more to be had, and why."""
        self.status, self.reason = why.status, why.reason

    def row(self) -> dict[str, Any]:
        """What is written of it; its agreement with others comes beside."""
        first = self.first
        structure: Structure | None = first.structure if first else None
        return {
            "tracer": self.tracer,
            "traversal": self.way.traversal,
            "precision": self.way.precision,
            "status": self.status,
            "reason": self.reason,
            "rays": self.rays,
            "seconds": self.times,
            "visits": asdict(first.visits) if first and first.visits else None,
            "structure": asdict(structure) if structure else None,
            "peak_bytes": first.peak_bytes if first else None,
            "joules": self.joules,
            "energy_reason": self.energy_reason,
        }
