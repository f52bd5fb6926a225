"""A small run that nothing disturbs, made once for the tests that disturb others."""

from __future__ import annotations

import pytest
from runs import Run, make_run


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A complete small run, which tests may read and none may change."""
    run = make_run(tmp_path_factory.mktemp("undisturbed") / "haste")
    run.run()
    return run
