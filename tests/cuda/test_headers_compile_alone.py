"""Every header of the core stands alone, for the CPU's compiler and for the GPU's.

A header that leans on what its users happen to include breaks far from its cause.
"""

import os
import shutil
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2] / "haste_cuda"
CORE_HEADERS = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("core/**/*.h"))
KERNEL_HEADERS = sorted(
    path.relative_to(ROOT).as_posix() for path in ROOT.glob("cuda/kernels/*.cuh")
)
WORKERS = 2


def host_compiler() -> str:
    """The C++ compiler that the extension would be built with."""
    compiler = shutil.which(os.environ.get("CXX", "g++"))
    if compiler is None:
        pytest.skip("no C++ compiler: neither $CXX nor g++ is on the path")
    return compiler


def host_complaint(program: str) -> str:
    """What g++ says about a program; empty if it has nothing to say."""
    command = [host_compiler(), "-std=c++20", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
    command += ["-fsyntax-only", "-I", str(ROOT), "-x", "c++", "-"]
    result = subprocess.run(command, input=program, capture_output=True, text=True, check=False)
    return result.stderr if result.returncode != 0 else ""


def device_complaint(core: ModuleType, program: str) -> str:
    """What NVRTC says about a program, warnings included; empty if it has nothing to say."""
    try:
        log = core.compile_source(program, 90, ["--fmad=false"], "alone.cu", use_cache=False)["log"]
    except core.CompileError as error:
        return str(error)
    return "\n".join(line for line in log.splitlines() if not line.startswith("ptxas info"))


def complaints(headers: list[str], complaint: Callable[[str], str]) -> list[str]:
    """What a compiler says about one-line programs, one a header."""
    assert headers, f"no headers below {ROOT}"
    programs = [f'#include "{header}"\n' for header in headers]
    with ThreadPoolExecutor(WORKERS) as pool:
        answers = pool.map(complaint, programs)
    return [
        f"{header}:\n{answer}" for header, answer in zip(headers, answers, strict=True) if answer
    ]


def test_every_core_header_compiles_alone_for_the_cpu():
    found = complaints(CORE_HEADERS, host_complaint)
    assert not found, "\n".join(found)


def test_every_header_compiles_alone_for_the_gpu(compiler: ModuleType):
    found = complaints(
        CORE_HEADERS + KERNEL_HEADERS, lambda program: device_complaint(compiler, program)
    )
    assert not found, "\n".join(found)


@pytest.mark.parametrize("fault", ["#include <vector>\n", "inline Unknown f() { return {}; }\n"])
def test_a_header_that_does_not_stand_alone_is_seen(compiler: ModuleType, fault: str):
    """Negative control: a standard header on the GPU, an undeclared name on both sides."""
    assert device_complaint(compiler, fault)
    if "Unknown" in fault:
        assert host_complaint(fault)


def test_the_core_includes_standard_headers_in_one_file_only():
    offenders = [
        f"{header}: {line.strip()}"
        for header in CORE_HEADERS
        if header != "core/config.h"
        for line in (ROOT / header).read_text().splitlines()
        if line.lstrip().startswith("#include <")
    ]
    assert not offenders, "\n".join(offenders)
