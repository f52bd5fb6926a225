"""The extension's replays: which traversals it has, how one is called, and what it is built of."""

from collections.abc import Callable, Mapping
from typing import Any

from harness.tracers.rays import Structure

ONLY = "bvh2"
"""The traversal of an extension that does not name any."""


def traversals() -> tuple[str, ...]:
    """Names of the extension's traversals, that of the images first."""
    from haste_cuda import _core

    if not hasattr(_core, "traversals"):
        return (ONLY,)
    first = _core.default_traversal() if hasattr(_core, "default_traversal") else ONLY
    return (first, *(name for name in _core.traversals() if name != first))


def replay(
    trace: Callable[..., dict[str, Any]], how: Mapping[str, object], *, repeats: int, count: bool
) -> tuple[dict[str, Any], tuple[float, ...]]:
    """Call one of the extension's replays.

    Parameters
    ----------
    trace
        The replay, with its scene and rays.
    how
        Further keywords; ``traversal`` is among them where there is a choice.
    repeats, count
        As of `Tracer.trace`.

    Returns
    -------
    answer, times
        The last answer, and seconds of each repeat.
    """
    from haste_cuda import _core

    if hasattr(_core, "traversals"):
        answer = trace(**how, repeats=repeats, **({"count": True} if count else {}))
        return answer, tuple(float(seconds) for seconds in answer["seconds"])
    plain = {key: value for key, value in how.items() if key != "traversal"}
    times = []
    for _ in range(repeats):
        answer = trace(**plain)
        times.append(float(answer["seconds"]))
    return answer, tuple(times)


def structure_of(scene: Any, traversal: str) -> Structure:
    """What a traversal walks through: seconds of its build, and bytes."""
    from haste_cuda import _core

    if hasattr(_core, "bvh_bytes"):
        size, seconds = _core.bvh_bytes(scene, traversal), _core.bvh_build_seconds(scene, traversal)
        return Structure(float(seconds), float(size))
    return Structure(float(scene.bvh["build_seconds"]), float(scene.bvh["bytes"]))
