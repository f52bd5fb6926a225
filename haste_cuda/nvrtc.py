"""Where NVRTC may be: the library that compiles the CUDA kernels when they are first needed.

A wheel of NVIDIA's is enough (``nvidia-cuda-nvrtc``, for CUDA 12 ``nvidia-cuda-nvrtc-cu12``);
a CUDA Toolkit serves as well. A driver loads programs of its own major version of CUDA and of older
ones, so of what is found here the extension takes the newest that the driver can follow. It does so
when it first compiles: importing the package initialises no driver, which would be in the way of
processes that fork.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from haste_cuda import _core

SUPPORTED_MAJORS = (13, 12)
"""Major versions of NVRTC that are looked for, newest first."""


def wheel_folders(major: int) -> Iterator[Path]:
    """Folders in which the wheels of this major version install the library."""
    spec = importlib.util.find_spec("nvidia")
    for location in (spec.submodule_search_locations or ()) if spec else ():
        yield Path(location) / f"cu{major}" / "lib"
        yield Path(location) / "cuda_nvrtc" / "lib"


def toolkit_folders(major: int) -> Iterator[Path]:
    """Folders in which a CUDA Toolkit keeps the library: $CUDA_HOME, $CUDA_PATH, /usr/local."""
    homes = [os.environ[name] for name in ("CUDA_HOME", "CUDA_PATH") if os.environ.get(name)]
    for home in (*homes, "/usr/local/cuda", f"/usr/local/cuda-{major}"):
        yield Path(home) / "lib64"


def nvrtc_candidates() -> list[tuple[int, str]]:
    """List the places where NVRTC may be, best first.

    Returns
    -------
    list[tuple[int, str]]
        Major version and path: files that exist, in wheels before toolkits, then the library's bare
        name, which the dynamic linker looks for on its own path.
    """
    candidates = []
    for major in SUPPORTED_MAJORS:
        name = f"libnvrtc.so.{major}"
        files = (folder / name for folder in (*wheel_folders(major), *toolkit_folders(major)))
        candidates += [(major, str(file)) for file in files if file.is_file()]
        candidates.append((major, name))
    return candidates


@cache
def configure() -> None:
    """Tell the extension where NVRTC and the kernels' headers are, before CUDA is first used."""
    _core.set_nvrtc_candidates(nvrtc_candidates())
    _core.set_include_root(str(Path(__file__).parent))
