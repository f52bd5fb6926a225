"""Files that are either complete or not there, and keys that say what they are the result of."""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray


def _write(path: Path, write: Callable[[BinaryIO], object]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    # In the same folder: a rename is atomic within one file system only.
    descriptor, temporary = tempfile.mkstemp(prefix=".partial-", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            write(file)
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    _write(path, lambda file: file.write(text.encode()))


def write_json(path: Path, value: object) -> None:
    """Write a JSON file, whole or not at all."""
    write_text(path, json.dumps(value, indent=1, sort_keys=True, allow_nan=False) + "\n")


def read_json(path: Path) -> Any:
    """Read a JSON file; None if there is none, or it is not JSON."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def write_image(path: Path, image: NDArray[np.floating]) -> None:
    """Write an image [height, width, 3] as a float32 .npy file, whole or not at all."""
    pixels = np.ascontiguousarray(image, dtype=np.float32)
    _write(path, lambda file: np.save(file, pixels, allow_pickle=False))


def key_of(parts: Mapping[str, object]) -> str:
    """Hash what a result depends on. Equal parts give equal keys on every machine."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def hash_files(paths: Iterable[Path]) -> str:
    """Hash the content of files, in the order of their names; SHA-256, hexadecimal."""
    total = hashlib.sha256()
    for path in sorted(paths):
        total.update(path.name.encode())
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


def remove_partial(folder: Path) -> None:
    """Remove what a killed process left half written."""
    for path in folder.rglob(".partial-*"):
        path.unlink(missing_ok=True)


def keep_only(folder: Path, wanted: set[Path]) -> None:
    """Remove the images of other settings below a folder, with their JSON files.

    A reader of the folder takes every image in it for one of this run.
    """
    for path in folder.rglob("*"):
        if path.suffix in {".npy", ".json"} and path.with_suffix("") not in wanted:
            path.unlink()
