"""Libraries that play drivers and compilers which no test machine has.

Each is C source compiled into a folder of its own; a fresh process then finds it in place of the
real library.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

SOURCES = Path(__file__).parents[2] / "haste_cuda" / "cuda"


def stub_driver(version: int, devices: int = 1, init: int = 0) -> str:
    """C source of a driver that answers the first questions and fails every other call."""
    text = 'int {0}(int r, const char **s) {{ (void)r; *s = "{1}"; return 0; }}'
    answers = {
        "cuInit": f"int cuInit(unsigned flags) {{ (void)flags; return {init}; }}",
        "cuDriverGetVersion": f"int cuDriverGetVersion(int *v) {{ *v = {version}; return 0; }}",
        "cuDeviceGetCount": f"int cuDeviceGetCount(int *n) {{ *n = {devices}; return 0; }}",
        "cuGetErrorName": text.format("cuGetErrorName", "CUDA_ERROR_STUB"),
        "cuGetErrorString": text.format("cuGetErrorString", "the stub's text"),
    }
    return with_every_entry_point("driver_api.cpp", answers)


def stub_nvrtc(major: int, minor: int) -> str:
    """C source of an NVRTC that tells its version and fails every other call."""
    version = f"int nvrtcVersion(int *a, int *b) {{ *a = {major}; *b = {minor}; return 0; }}"
    return with_every_entry_point("nvrtc.cpp", {"nvrtcVersion": version})


def with_every_entry_point(file: str, answers: dict[str, str]) -> str:
    """The answers, and a failure for every other function that the C++ file looks up."""
    names = re.findall(r'find\("(\w+)"', (SOURCES / file).read_text())
    assert set(answers) <= set(names), f"{file} looks up {names}"
    failures = {name: f"int {name}(void) {{ return 999; }}" for name in names}
    return "\n".join({**failures, **answers}.values()) + "\n"


def build_library(path: Path, source: str) -> Path:
    """Compile C source to a shared library; its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    code = path.with_suffix(".c")
    code.write_text(source)
    subprocess.run(["gcc", "-shared", "-fPIC", "-w", "-o", path, code], check=True)
    return path


def run_python(program: str, library_folder: Path | None = None) -> str:
    """Run Python whose dynamic linker searches `library_folder` first; what it printed."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    if library_folder is not None:
        environment["LD_LIBRARY_PATH"] = str(library_folder)
    result = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()
