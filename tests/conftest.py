"""What every test shares: pictures without a display, generated meshes, one rule for tests that
need a GPU, and who runs which test where several processes do (pytest-xdist)."""

from __future__ import annotations

import os
from typing import Any

import pytest
from parts import MOST_WORKERS, TOGETHER, part_of

os.environ["MPLBACKEND"] = "Agg"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--killed-preset",
        metavar="FILE",
        help="also run this preset of config/ whole, twice, killing the second run twenty times",
    )


def pytest_sessionstart(session: pytest.Session) -> None:
    """Make the files of scenes that are generated and not there, or old: a few seconds, once.

    Where several processes run the tests, the one that directs them does, before they start.
    """
    if hasattr(session.config, "workerinput"):
        return
    from harness.generate import generate_outdated

    generate_outdated()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what is dear first, and skip tests marked `gpu` where CUDA is unavailable."""
    items.sort(key=lambda item: part_of(item.nodeid) not in TOGETHER)
    need_a_gpu = [item for item in items if item.get_closest_marker("gpu")]
    if not need_a_gpu:
        return
    import haste_cuda

    reason = haste_cuda.cuda_unavailable()
    if reason is not None:
        for item in need_a_gpu:
            item.add_marker(pytest.mark.skip(reason=reason))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """A process for each core that this one may use."""
    return min(len(os.sched_getaffinity(0)), MOST_WORKERS)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give parts of the suite to processes in the order of collection."""
    from xdist.scheduler import LoadScopeScheduling

    class Parts(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return part_of(nodeid)

    if config.getvalue("dist") != "loadfile":
        return None
    config.option.loadscopereorder = False
    return Parts(config, log)
