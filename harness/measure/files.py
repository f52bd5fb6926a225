"""Files that are either complete or not there, and keys that say what they are the result of."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.whole_files import partial_files, write_array, write_whole


def write_json(path: Path, value: object) -> None:
    """Write a JSON file, whole or not at all."""
    write_whole(path, json.dumps(value, indent=1, sort_keys=True, allow_nan=False) + "\n")


def read_json(path: Path) -> Any:
    """Read a JSON file; None if there is none, or it is not JSON."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def find_record(path: Path, key: str) -> dict[str, Any] | None:
    """Read a record whose `key` says that it is of what is wanted; None if there is no such."""
    known = read_json(path)
    return known if isinstance(known, dict) and known.get("key") == key else None


def write_image(path: Path, image: NDArray[np.floating]) -> None:
    """Write an image [height, width, 3] as a float32 .npy file, whole or not at all."""
    write_array(path, np.ascontiguousarray(image, dtype=np.float32))


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


def remove_partial(folder: Path, *, of_truth: bool) -> None:
    """Remove what a killed process left half written below a scene's folder.

    The truth and the tracers of a scene may be at work side by side, on two machines; each clears
    away its own only.
    """
    for partial, path in list(partial_files(folder)):
        if (path.parts[0] in {"truth", "truth.json"}) == of_truth:
            partial.unlink(missing_ok=True)


def keep_only(folder: Path, wanted: set[Path]) -> None:
    """Remove the images of other settings below a folder, with their JSON files.

    A reader of the folder takes every image in it for one of this run.
    """
    for path in folder.rglob("*"):
        if path.suffix in {".npy", ".json"} and path.with_suffix("") not in wanted:
            path.unlink()
