"""What every test shares: pictures without a display, generated meshes, and one rule for tests that
need a GPU."""

from __future__ import annotations

import os

import pytest

os.environ["MPLBACKEND"] = "Agg"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--killed-preset",
        metavar="FILE",
        help="also run this preset of config/ whole, twice, killing the second run twenty times",
    )


def pytest_sessionstart() -> None:
    """Make the files of scenes that are generated and not there, or old: a few seconds, once."""
    from harness.generate import generate_outdated

    generate_outdated()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip the tests marked `gpu`, with the reason, where CUDA is unavailable."""
    need_a_gpu = [item for item in items if item.get_closest_marker("gpu")]
    if not need_a_gpu:
        return
    import haste_cuda

    reason = haste_cuda.cuda_unavailable()
    if reason is not None:
        for item in need_a_gpu:
            item.add_marker(pytest.mark.skip(reason=reason))
