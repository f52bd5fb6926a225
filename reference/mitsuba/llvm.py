"""Chooses the LLVM library that Dr.Jit loads.

Dr.Jit opens the first ``libLLVM`` that the dynamic linker finds. Below version 16 that ends the
process (an abort inside LLVM, which Python cannot catch), so the library is chosen here, by
version, before Dr.Jit starts its LLVM backend.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

ENVIRONMENT_VARIABLE = "DRJIT_LIBLLVM_PATH"
OLDEST_USABLE = 16
# Versions this project has been run with come first; newer ones are tried after them.
PREFERENCE = (19, 18, 17, 16)
INSTALL_COMMAND = "apt-get install libllvm19"

SEARCH_PATTERNS = (
    "/usr/lib/*-linux-gnu/libLLVM*",
    "/usr/lib/llvm-*/lib/libLLVM*",
    "/usr/lib64/libLLVM*",
    "/usr/lib64/llvm*/lib*/libLLVM*",
    "/usr/lib/libLLVM*",
    "/usr/local/lib/libLLVM*",
    "/opt/homebrew/opt/llvm*/lib/libLLVM*",
    "/usr/local/opt/llvm*/lib/libLLVM*",
)

# libLLVM-15.so.1, libLLVM-16.so, libLLVM.so.19.1, libLLVM.19.1.dylib
_VERSIONED_NAME = re.compile(
    r"libLLVM(?:-(?P<dash>\d+)[\d.]*)?\.(?:(?P<mac>\d+)[\d.]*\.)?(?:so|dylib)(?:\.(?P<so>\d+)[\d.]*)?"
)


@dataclass(frozen=True, slots=True)
class LlvmChoice:
    """The library to load, or the reason why there is none (exactly one of the two is set)."""

    path: str | None
    version: int | None
    reason: str | None


def library_version(path: Path) -> int | None:
    """Major LLVM version in the name of ``path``, or of the file it links to; None if neither."""
    for name in (path.name, path.resolve().name):
        match = _VERSIONED_NAME.fullmatch(name)
        if match is None:
            continue
        version = match["dash"] or match["mac"] or match["so"]
        # A bare "libLLVM.so.1" carries an ABI number, not an LLVM version.
        if version is not None and int(version) > 1:
            return int(version)
    return None


def installed_libraries(patterns: tuple[str, ...] = SEARCH_PATTERNS) -> dict[int, Path]:
    """One shared LLVM library per major version, from the usual places of a system."""
    found: dict[int, Path] = {}
    for pattern in patterns:
        for path in sorted(Path("/").glob(pattern.lstrip("/"))):
            version = library_version(path)
            if version is not None and path.exists():
                found.setdefault(version, path)
    return found


def _order(version: int) -> tuple[int, int]:
    if version in PREFERENCE:
        return 0, PREFERENCE.index(version)
    return 1, version


def choose(requested: str | None, installed: dict[int, Path]) -> LlvmChoice:
    """The library to use: ``requested`` where it is usable, else the best of ``installed``."""
    if requested:
        path = Path(requested)
        if not path.exists():
            return LlvmChoice(
                None, None, f"{ENVIRONMENT_VARIABLE}={requested}: there is no such file"
            )
        version = library_version(path)
        if version is not None and version < OLDEST_USABLE:
            return LlvmChoice(
                None,
                None,
                f"{ENVIRONMENT_VARIABLE}={requested} is LLVM {version}; "
                f"Dr.Jit needs {OLDEST_USABLE} or newer: {INSTALL_COMMAND}",
            )
        return LlvmChoice(requested, version, None)
    usable = sorted((v for v in installed if v >= OLDEST_USABLE), key=_order)
    if not usable:
        versions = ", ".join(str(version) for version in sorted(installed)) or "none"
        return LlvmChoice(
            None,
            None,
            f"Dr.Jit needs LLVM {OLDEST_USABLE} or newer (installed: {versions}): "
            f"{INSTALL_COMMAND}",
        )
    return LlvmChoice(str(installed[usable[0]]), usable[0], None)


def select_library() -> LlvmChoice:
    """Chooses a library and names it to Dr.Jit through the environment.

    Call it before the first ``llvm_*`` variant of Mitsuba is used; Dr.Jit reads the variable once.
    """
    choice = choose(os.environ.get(ENVIRONMENT_VARIABLE), installed_libraries())
    if choice.path is not None:
        os.environ[ENVIRONMENT_VARIABLE] = choice.path
    return choice
