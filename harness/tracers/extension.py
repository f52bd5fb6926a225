"""The extension's replays: which traversals it has, how one is called, and what it is built of."""

from collections.abc import Callable, Mapping
from typing import Any

from harness.tracers.rays import Structure


def traversals() -> tuple[str, ...]:
    """Names of the extension's traversals, that of replays which name none first."""
    from haste_cuda import _core

    first = _core.default_traversal()
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
        Further keywords, such as ``traversal``.
    repeats, count
        As of `Tracer.trace`.

    Returns
    -------
    answer, times
        The last answer, and the time of each repeat, [s].
    """
    answer = trace(**how, repeats=repeats, **({"count": True} if count else {}))
    return answer, tuple(float(seconds) for seconds in answer["seconds"])


def structure_of(scene: Any, traversal: str) -> Structure:
    """What a traversal walks through: time of its build, [s], and size, [B]."""
    from haste_cuda import _core

    size, seconds = _core.bvh_bytes(scene, traversal), _core.bvh_build_seconds(scene, traversal)
    return Structure(float(seconds), float(size))
