"""Rays in a file: one .npz a scene, the same bytes for the same rays."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from harness.tracers.rays import Rays
from harness.whole_files import written_whole

PARTS = ("origins", "directions", "t_min", "t_max")


def write_rays(path: Path, rays: Mapping[str, Rays]) -> None:
    """Write rays by class, whole or not at all: float32 arrays ``<class>.<part>`` of `PARTS`.

    A zip file without compression: directions are noise, which none makes smaller.
    """
    arrays = {f"{name}.{part}": getattr(one, part) for name, one in rays.items() for part in PARTS}
    with written_whole(path) as (temporary,), temporary.open("wb") as file:
        np.savez(file, **arrays)


def read_rays(path: Path, name: str) -> Rays:
    """Read one class of rays.

    Raises
    ------
    OSError, ValueError, KeyError
        There is no such file, it is damaged, or it has no such class.
    """
    with np.load(path, allow_pickle=False) as file:
        return Rays(*(file[f"{name}.{part}"] for part in PARTS))


def hash_file(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
