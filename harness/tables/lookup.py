"""measurements.csv as the report reads it: every published number comes from that file."""

from __future__ import annotations

import csv
import gzip
import io
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from harness.statistics.intervals import Interval
from harness.tables.read import ResultsError, tracer_order
from harness.tables.schema import parse_case


@dataclass(frozen=True, slots=True)
class Measurement:
    """One row of measurements.csv."""

    scene: str
    tracer: str
    model: str
    engine: str
    precision: str
    case: str
    quantity: str
    interval: Interval
    unit: str
    status: str
    note: str


class Measurements:
    """The rows of measurements.csv, with the questions that are asked of them."""

    def __init__(self, rows: Iterable[Measurement]) -> None:
        self.rows = tuple(rows)
        self._index: dict[tuple[str, ...], dict[str, Measurement]] = {}
        for row in self.rows:
            key = (row.quantity, row.scene, row.model, row.tracer, row.engine)
            self._index.setdefault(key, {})[row.case] = row

    def tracers(self, quantity: str, scene: str, model: str) -> list[str]:
        """Tracers of which a quantity was measured, in the order of the registry."""
        found = {
            row.tracer
            for row in self.rows
            if (row.quantity, row.scene, row.model, row.status) == (quantity, scene, model, "ok")
        }
        return sorted(found - {"truth"}, key=tracer_order)

    def cases(
        self, quantity: str, *, scene: str, model: str, tracer: str, engine: str = "depth_first"
    ) -> list[str]:
        """Cases in which a quantity was measured, in the order of the file."""
        return list(self._index.get((quantity, scene, model, tracer, engine), {}))

    def find(
        self,
        quantity: str,
        *,
        scene: str,
        model: str,
        tracer: str,
        case: str = "",
        engine: str = "depth_first",
    ) -> Interval | None:
        """The interval of one measured quantity, or None if there is none."""
        row = self._index.get((quantity, scene, model, tracer, engine), {}).get(case)
        return row.interval if row is not None and row.status == "ok" else None

    def sweep(
        self,
        quantity: str,
        key: str,
        *,
        scene: str,
        model: str,
        tracer: str,
        engine: str = "depth_first",
        **fixed: str | int,
    ) -> dict[int, Interval]:
        """A quantity by the value of one key, in rising order; other keys must equal `fixed`."""
        found = {}
        for text, row in self._index.get((quantity, scene, model, tracer, engine), {}).items():
            case = parse_case(text)
            value = case.pop(key, None)
            if row.status == "ok" and value is not None and case == fixed:
                found[int(value)] = row.interval
        return dict(sorted(found.items()))


def find_measurements(folder: Path) -> Path:
    """The measurements of a results folder: measurements.csv, compressed where it is published."""
    packed = folder / "measurements.csv.gz"
    return packed if packed.exists() else folder / "measurements.csv"


def read_measurements(path: Path) -> Measurements:
    """Read measurements.csv or measurements.csv.gz; raises ResultsError if it cannot be read."""
    try:
        packed = path.read_bytes()
        text = (gzip.decompress(packed) if path.suffix == ".gz" else packed).decode()
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from error

    def number(value: str) -> float:
        return float(value) if value else float("nan")

    return Measurements(
        Measurement(
            row["scene"],
            row["tracer"],
            row["model"],
            row["engine"],
            row["precision"],
            row["case"],
            row["quantity"],
            Interval(
                number(row["value"]), number(row["lower"]), number(row["upper"]), int(row["n"])
            ),
            row["unit"],
            row["status"],
            row["note"],
        )
        for row in csv.DictReader(io.StringIO(text))
    )
