"""Closed lists of names, and the only way to add a row to a table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from harness.statistics.intervals import Interval

SCHEMAS = Path(__file__).resolve().parents[1] / "schemas"
TYPES: dict[str, type] = {
    "integer": Integral,
    "number": Real,
    "string": str,
}
COLUMN_TYPES = {"integer": "int64", "number": "float64", "string": "str"}


class SchemaError(Exception):
    """A name or value is not in the closed lists; the message says which, and what is allowed."""


@cache
def load_list(name: str) -> dict[str, dict[str, Any]]:
    """Read harness/schemas/<name>.yaml."""
    entries: dict[str, dict[str, Any]] = yaml.safe_load((SCHEMAS / f"{name}.yaml").read_text())
    return entries


def unit_of(quantity: str) -> str:
    """Unit of a quantity; raises SchemaError if it is not in quantities.yaml."""
    quantities = load_list("quantities")
    if quantity not in quantities:
        raise SchemaError(
            f"unknown quantity {quantity!r}; harness/schemas/quantities.yaml has "
            + ", ".join(quantities)
        )
    return str(quantities[quantity]["unit"])


def format_case(case: Mapping[str, object]) -> str:
    """Write what was swept as sorted key=value pairs joined by ';'; raises SchemaError."""
    keys = load_list("keys")
    for key, value in case.items():
        if key not in keys:
            raise SchemaError(
                f"unknown key {key!r} in case {dict(case)}; harness/schemas/keys.yaml has "
                + ", ".join(keys)
            )
        entry = keys[key]
        allowed = entry.get("values")
        right = value in allowed if allowed else isinstance(value, TYPES[entry["type"]])
        if not right or isinstance(value, bool):
            raise SchemaError(
                f"case {key}={value!r}: expected "
                + (
                    f"one of {', '.join(allowed)}"
                    if allowed
                    else f"a value of type {entry['type']}"
                )
            )
    return ";".join(f"{key}={case[key]}" for key in sorted(case))


def parse_case(text: str) -> dict[str, int | float | str]:
    """Read back what `format_case` wrote; raises SchemaError for an unknown key."""
    case: dict[str, int | float | str] = {}
    for pair in filter(None, text.split(";")):
        key, _, value = pair.partition("=")
        entry = load_list("keys").get(key)
        if entry is None:
            raise SchemaError(f"unknown key {key!r} in case {text!r}")
        kind = entry.get("type", "string")
        case[key] = int(value) if kind == "integer" else float(value) if kind == "number" else value
    return case


@dataclass(frozen=True, slots=True)
class Subject:
    """What was measured: the columns that both tables share."""

    run: str
    scene: str
    tracer: str
    model: str
    engine: str
    precision: str


@dataclass
class Recorder:
    """Collects the rows of both tables; every name is checked as it comes in."""

    samples: list[dict[str, object]] = field(default_factory=list)
    measurements: list[dict[str, object]] = field(default_factory=list)

    def sample(
        self,
        subject: Subject,
        quantity: str,
        value: float,
        *,
        seed: int,
        spp: int,
        case: Mapping[str, object] | None = None,
        status: str = "ok",
        note: str = "",
    ) -> None:
        """Add one seed's or repeat's value; raises SchemaError for what the schema refuses."""
        row = {
            **_columns(subject),
            "case": format_case(case or {}),
            "seed": seed,
            "spp": spp,
            "quantity": quantity,
            "value": float(value),
            "unit": unit_of(quantity),
            "status": status,
            "note": note,
        }
        self.samples.append(_checked(row, "samples"))

    def measure(
        self,
        subject: Subject,
        quantity: str,
        interval: Interval,
        case: Mapping[str, object] | None = None,
        *,
        status: str = "ok",
        note: str = "",
    ) -> None:
        """Add one measured quantity; raises SchemaError for what the schema refuses."""
        row = {
            **_columns(subject),
            "case": format_case(case or {}),
            "quantity": quantity,
            "value": interval.value,
            "lower": interval.lower,
            "upper": interval.upper,
            "unit": unit_of(quantity),
            "n": interval.n,
            "status": status,
            "note": note,
        }
        self.measurements.append(_checked(row, "measurements"))

    def frames(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """Both tables, samples first, with the columns and types of their schemas."""
        return _frame(self.samples, "samples"), _frame(self.measurements, "measurements")


def _columns(subject: Subject) -> dict[str, object]:
    return {
        "run": subject.run,
        "scene": subject.scene,
        "tracer": subject.tracer,
        "model": subject.model,
        "engine": subject.engine,
        "precision": subject.precision,
    }


def _checked(row: dict[str, Any], table: str) -> dict[str, Any]:
    """The row, if each column is what the table's schema says and it makes sense as a whole.

    Raises
    ------
    SchemaError
        Naming table, column, value and what is allowed.
    """
    for column, entry in load_list(table).items():
        value, allowed = row[column], entry.get("values")
        if allowed is not None and value not in allowed:
            raise SchemaError(f"{table}.{column}: {value!r} is not one of {', '.join(allowed)}")
        kind = entry.get("type", "string")
        if not isinstance(value, TYPES[kind]) or isinstance(value, bool):
            raise SchemaError(f"{table}.{column}: {value!r} is not of type {kind}")
    where = f"{row['scene']} {row['model']} {row['tracer']} {row['quantity']}"
    if row["status"] != "ok" and not row["note"]:
        raise SchemaError(
            f"{table}.note: a row of status {row['status']} needs the reason ({where})"
        )
    value, lower, upper = (row.get(column, row["value"]) for column in ("value", "lower", "upper"))
    if row["status"] == "ok" and math.isnan(value):
        raise SchemaError(f"{table}.value: a row of status ok has none ({where})")
    # Not-a-number stands for a bound that is not known.
    if lower > value or upper < value:
        raise SchemaError(
            f"{table}.value: {value:g} is not within {lower:g} and {upper:g} ({where})"
        )
    return row


def _frame(rows: list[dict[str, object]], name: str) -> pd.DataFrame:
    columns = load_list(name)
    types = {key: COLUMN_TYPES[entry.get("type", "string")] for key, entry in columns.items()}
    return pd.DataFrame(rows, columns=list(columns)).astype(types)
