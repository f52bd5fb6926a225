"""Every header around the core compiles alone (tests/cuda says the same of the core)."""

from __future__ import annotations

import os
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
PACKAGE = REPOSITORY / "haste_cuda"
HEADERS = sorted(
    header
    for folder in (PACKAGE, REPOSITORY / "reference")
    for header in folder.rglob("*.h")
    if PACKAGE / "core" not in header.parents
)
COMPILER = os.environ.get("CXX", "c++")


def include_folders() -> list[str]:
    import sysconfig

    import nanobind

    return [sysconfig.get_path("include"), nanobind.include_dir()]


def compiled_alone(header: Path) -> str:
    """What g++ says of a file that holds nothing but this header; empty if it is content."""
    embree = 4 if Path("/usr/include/embree4").exists() else 3
    result = subprocess.run(
        [
            *(COMPILER, "-std=c++20", "-fsyntax-only", "-ffp-contract=off"),
            *("-Wall", "-Wextra", "-Werror", f"-DHASTE_EMBREE_MAJOR={embree}"),
            *(f"-I{PACKAGE}", f"-I{REPOSITORY}"),
            *(f"-isystem{folder}" for folder in include_folders()),
            *("-x", "c++", "-"),
        ],
        input=f'#include "{header}"\n',
        capture_output=True,
        text=True,
        check=False,
    )
    return result.stderr if result.returncode else ""


@pytest.mark.skipif(shutil.which(COMPILER) is None, reason=f"there is no compiler {COMPILER}")
def test_every_header_compiles_alone() -> None:
    assert len(HEADERS) > 10, "the headers were not found"
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        complaints = pool.map(compiled_alone, HEADERS)
    refused = [
        f"{header}:\n{text}" for header, text in zip(HEADERS, complaints, strict=True) if text
    ]
    assert not refused, "\n".join(refused)


@pytest.mark.skipif(shutil.which(COMPILER) is None, reason=f"there is no compiler {COMPILER}")
def test_a_header_that_leans_on_another_is_refused(tmp_path: Path) -> None:
    header = tmp_path / "leaning.h"
    header.write_text("#pragma once\ninline haste::u32 one() { return 1; }\n")
    assert "haste" in compiled_alone(header)
