"""Turned knobs in words and in order."""

from __future__ import annotations

from collections.abc import Mapping

from harness.tables.knobs import KNOBS

Turned = Mapping[str, int | float | str]


def turned_of(case: Mapping[str, int | float | str]) -> dict[str, int | float | str]:
    """What was turned of a case; empty for the settings of the scene."""
    return {key: case[key] for key in KNOBS if key in case}


def knob_of(turned: Turned) -> str:
    """The knob that a turn of `path` is about: not the depth that stands for no limit beside it."""
    keys = [key for key in KNOBS if key in turned]
    return keys[-1] if keys else ""


def name_of_turn(turned: Turned) -> str:
    """What was turned, in words."""
    if "light_samples" in turned:
        return f"{turned['light_samples']} light × {turned['ambient_samples']} ambient"
    knob = knob_of(turned)
    value = turned.get(knob, "")
    return f"{knob} {value:g}" if isinstance(value, int | float) else str(value)


def turn_order(turned: Turned) -> tuple[int, tuple[float, ...]]:
    """Sort key of a turn: which knob, and by how much."""
    knob = knob_of(turned)
    values = [float(v) for v in reversed(turned.values()) if isinstance(v, int | float)]
    return (KNOBS.index(knob) if knob in KNOBS else -1, tuple(values))


def extend(case: str, **more: str) -> str:
    """A case as it is written with more keys, its values left as they are."""
    pairs = [*filter(None, case.split(";")), *(f"{key}={value}" for key, value in more.items())]
    return ";".join(sorted(pairs))


def only_turned(case: str) -> str:
    """What was turned of a case as it is written."""
    return ";".join(pair for pair in case.split(";") if pair.partition("=")[0] in KNOBS)
