"""What a render's copies, kernels and queue took, from when each of them began and ended."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

COPIES = ("upload", "download")
QUEUE = ("pop", "push")


@dataclass(frozen=True, slots=True)
class WorkSpan:
    """A stretch of a render's time, in seconds from its beginning."""

    kind: str
    """pop, allocate, upload, trace, download or push"""
    lane: int
    """the stream it belongs to"""
    begin: float
    end: float
    rays: int


@dataclass(frozen=True, slots=True)
class WorkSummary:
    """Seconds in which something of a kind was under way, however many at once."""

    copy_seconds: float
    kernel_seconds: float
    queue_seconds: float
    """taking packets from a queue on the host, and adding to it"""
    allocation_seconds: float
    overlap: float
    """share of the copies' time in which a kernel runs, too; NaN without copies"""


Stretches = list[tuple[float, float]]


def _merged(spans: Iterable[WorkSpan], kinds: Sequence[str]) -> Stretches:
    """Stretches in which at least one span of some kinds is under way, in order."""
    merged: Stretches = []
    for begin, end in sorted((span.begin, span.end) for span in spans if span.kind in kinds):
        if merged and begin <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(end, merged[-1][1]))
        else:
            merged.append((begin, end))
    return merged


def _length(stretches: Stretches) -> float:
    return sum(end - begin for begin, end in stretches)


def _common(first: Stretches, second: Stretches) -> float:
    """Length of what two lists of stretches have in common."""
    total, i, j = 0.0, 0, 0
    while i < len(first) and j < len(second):
        begin, end = max(first[i][0], second[j][0]), min(first[i][1], second[j][1])
        total += max(0.0, end - begin)
        if first[i][1] < second[j][1]:
            i += 1
        else:
            j += 1
    return total


def summarise_work(spans: Sequence[WorkSpan]) -> WorkSummary:
    """Add up what a render's time went into.

    Copies that run beside each other count once, as do kernels: two engines of the same GPU that
    copy at once take no more time than one.
    """
    copies, kernels = _merged(spans, COPIES), _merged(spans, ("trace",))
    copying = _length(copies)
    return WorkSummary(
        copying,
        _length(kernels),
        _length(_merged(spans, QUEUE)),
        _length(_merged(spans, ("allocate",))),
        _common(copies, kernels) / copying if copying > 0.0 else float("nan"),
    )
