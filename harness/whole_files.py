"""Files that appear whole or not at all, whatever ends the process that writes them."""

from __future__ import annotations

import io
import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

PARTIAL = ".partial-"
"""Begins the name of a file that is being written."""


@contextmanager
def written_whole(*paths: Path) -> Iterator[list[Path]]:
    """Files for a block to write, which take the places of `paths` when it ends.

    They lie beside them, since a rename is atomic within one file system only, and have names that
    no other process chooses. All are on the disk before the first is renamed: a full disk, or a
    machine that goes down, leaves under each name what was there before, or nothing. A killed
    process leaves its partial files behind, see `partial_files`.
    """
    temporaries = [path.with_name(f"{PARTIAL}{uuid.uuid4().hex}-{path.name}") for path in paths]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
    try:
        yield temporaries
        for temporary in temporaries:
            _flush(temporary)
        for temporary, path in zip(temporaries, paths, strict=True):
            temporary.replace(path)
    finally:
        for temporary in temporaries:
            temporary.unlink(missing_ok=True)


def _flush(path: Path) -> None:
    """Have the disk take what was written; raises OSError where it cannot."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text, as UTF-8, or bytes to a file, whole or not at all."""
    with written_whole(path) as (temporary,):
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def write_array(path: Path, array: NDArray[Any]) -> None:
    """Write a .npy file, whole or not at all."""
    # To memory first: NumPy writes a file's last bytes without looking whether there was room.
    content = io.BytesIO()
    np.save(content, array, allow_pickle=False)
    write_whole(path, content.getvalue())


def partial_files(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Files that are being written below a folder, or that a killed process was writing.

    Each comes with the path that it was to have, relative to the folder.
    """
    for path in folder.rglob(f"{PARTIAL}*"):
        name = path.name.removeprefix(PARTIAL).partition("-")[2]
        yield path, path.relative_to(folder).with_name(name)
