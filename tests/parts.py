"""Which tests one process runs with each other, where several processes run the tests."""

from __future__ import annotations

TOGETHER = ("tests/harness/workflow", "tests/harness/browser")
"""Folders whose tests share a run or a browser that is dear to make. One process has all tests of
such a folder, and the longest work comes first, so that none waits for it in the end."""
MOST_WORKERS = 4
"""Renders and compilations use every core by themselves; more processes would only cost memory."""


def part_of(nodeid: str) -> str:
    """The part of the suite that one process runs with all its tests: a file, or a folder."""
    file = nodeid.partition("::")[0]
    return next((folder for folder in TOGETHER if file.startswith(folder + "/")), file)
