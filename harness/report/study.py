"""What the study of packets found, read back from measurements.csv."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurements
from harness.tables.schema import format_case, parse_case
from harness.tables.study import StudyJob

ENGINES = ("packets", "streams", "layers", "wavefront", "persistent", "depth_first")
"""From the paper's queue to none."""
WORDS = {"per_packet": "allocated each time", "once": "allocated once"}
Panel = tuple[str, str]


@dataclass(frozen=True, slots=True)
class Variant:
    """One engine in one way of taking packets, on one scene in one model."""

    scene: str
    model: str
    tracer: str
    engine: str
    fixed: tuple[tuple[str, str | int], ...]
    """the parts of the case that are not the size of a launch"""

    @property
    def panel(self) -> Panel:
        """Scene and model."""
        return self.scene, self.model

    @property
    def order(self) -> str:
        """Which end of the queue packets are taken from; empty without a choice."""
        return str(dict(self.fixed).get("order", ""))

    @property
    def allocation(self) -> str:
        """When device memory is allocated; empty without a choice."""
        return str(dict(self.fixed).get("allocation", ""))

    @property
    def size_key(self) -> str:
        """What the size of a launch is called."""
        return "samples" if self.engine in {"depth_first", "persistent"} else "packet"

    @property
    def label(self) -> str:
        """The engine and its choices."""
        return ", ".join(filter(None, (self.engine, self.order, WORDS.get(self.allocation, ""))))

    def sweep(
        self, measurements: Measurements, quantity: str, **more: str | int
    ) -> dict[int, Interval]:
        """A quantity over the size of a launch."""
        where = {"scene": self.scene, "model": self.model, "tracer": self.tracer}
        fixed = {**dict(self.fixed), **more}
        return measurements.sweep(quantity, self.size_key, engine=self.engine, **where, **fixed)

    def find(self, measurements: Measurements, quantity: str) -> Interval | None:
        """A quantity of the whole sweep."""
        where = {"scene": self.scene, "model": self.model, "tracer": self.tracer}
        case = format_case(dict(self.fixed))
        return measurements.find(quantity, engine=self.engine, case=case, **where)

    def rates(self, measurements: Measurements) -> dict[int, Interval]:
        """Queued rays a second over the size of a launch."""
        return self.sweep(measurements, "rays_per_second", rays="queued")


def find_variants(measurements: Measurements) -> list[Variant]:
    """Everything that the study timed, in the order of the ladder."""
    found: dict[Variant, None] = {}
    for row in measurements.rows:
        if row.quantity != "launch_rays" or row.status != "ok":
            continue
        case = parse_case(row.case)
        if "film" in case:
            continue
        fixed = tuple(
            (k, v if isinstance(v, int) else str(v))
            for k, v in sorted(case.items())
            if k not in {"packet", "samples"}
        )
        found[Variant(row.scene, row.model, row.tracer, row.engine, fixed)] = None

    def place(variant: Variant) -> tuple[object, ...]:
        # The paper's allocation comes first, then the order of the names.
        once = variant.allocation != "per_packet"
        return variant.tracer, ENGINES.index(variant.engine), once, variant.order

    panels = list(dict.fromkeys(variant.panel for variant in found))
    return sorted(found, key=lambda variant: (panels.index(variant.panel), place(variant)))


def panels_of(variants: Iterable[Variant]) -> list[Panel]:
    """Scenes and models, in their order."""
    return list(dict.fromkeys(variant.panel for variant in variants))


def compared_sizes(jobs: Sequence[StudyJob]) -> list[int]:
    """The sizes of a launch at which ratios are taken, which every scene has."""
    sizes = {
        int(size)
        for job in jobs
        for size in job.provenance["config"]["study"]["elsewhere"]["sizes"]
    }
    return sorted(sizes)


def timelines(job: StudyJob) -> list[tuple[str, Sequence[Mapping[str, object]]]]:
    """Label and spans of the renders of a study that are drawn over time, the paper's first."""
    found = []
    for row in job.work:
        case = row["case"]
        other = {"film", "samples"} & set(case)
        drawn = row["status"] == "ok" and case.get("order") == "fifo" and not other
        if drawn and row.get("spans"):
            once = WORDS.get(str(case.get("allocation", "")), "")
            found.append((", ".join(filter(None, (row["engine"], once))), row["spans"]))
    return found
