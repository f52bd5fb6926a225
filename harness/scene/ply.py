"""What is wrong with a PLY file, in words that name the vertex or face.

Mitsuba reads the file; this only looks at it beforehand. Mitsuba stops at the first broken file of
a scene, does not say which vertex is not a number, and takes a negative index for 0.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

NAMES = {
    "i1": ("char", "int8"),
    "u1": ("uchar", "uint8"),
    "i2": ("short", "int16"),
    "u2": ("ushort", "uint16"),
    "i4": ("int", "int32"),
    "u4": ("uint", "uint32"),
    "f4": ("float", "float32"),
    "f8": ("double", "float64"),
}
TYPES = {name: kind for kind, names in NAMES.items() for name in names}
ENDIANS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


class _Unusual(Exception):  # noqa: N818 - not an error: Mitsuba shall judge the file
    """The file has something that is not looked into here."""


class _Broken(Exception):  # noqa: N818 - carries a sentence about the file
    """The file is broken; the message says how."""


@dataclass(frozen=True, slots=True)
class _Element:
    """One element of the header: its scalar properties, and its list if it has one."""

    name: str
    count: int
    properties: list[tuple[str, str, str | None]]
    """name, type, and for a list the type of its length"""


def check_ply(file: Path) -> str | None:
    """What is wrong with a PLY file, None if nothing is found.

    Looks for a file that ends too early, vertices that are NaN or infinite, and faces that refer to
    vertices that are not there. Lists of varying length are left to Mitsuba.
    """
    data = file.read_bytes()
    try:
        _check(data)
    except _Unusual:
        return None
    except _Broken as broken:
        return f'"{file.name}" {broken}'
    return None


def _check(data: bytes) -> None:
    if not data:
        raise _Broken("is empty")
    if not data.startswith(b"ply"):
        raise _Broken("is not a PLY file")
    head, end, body = data.partition(b"end_header")
    if not end:
        raise _Broken("is truncated: it ends within its header")
    lines = head.decode("ascii", errors="replace").splitlines()
    endian = next((line.split()[1] for line in lines if line.startswith("format ")), "")
    if endian not in ENDIANS:
        raise _Unusual
    elements = _elements(lines)
    vertices = next((element.count for element in elements if element.name == "vertex"), 0)
    body = body.partition(b"\n")[2]
    read = _read_text(body, elements) if endian == "ascii" else _read(body, elements, endian)
    for element, records in read:
        if element.name == "vertex":
            _check_vertices(records)
        elif element.name == "face":
            _check_faces(element, records, vertices)


def _elements(lines: list[str]) -> list[_Element]:
    found: list[_Element] = []
    for line in lines:
        match line.split():
            case ["element", name, count] if count.isdigit():
                found.append(_Element(name, int(count), []))
            case ["property", "list", length, kind, name] if found and {length, kind} <= set(TYPES):
                found[-1].properties.append((name, TYPES[kind], TYPES[length]))
            case ["property", kind, name] if found and kind in TYPES:
                found[-1].properties.append((name, TYPES[kind], None))
            case ["element" | "property", *_]:
                raise _Unusual
    return found


def _record(element: _Element, endian: str, length: int) -> np.dtype[Any]:
    """One record of an element whose list, if it has one, has `length` members."""
    fields: list[tuple[Any, ...]] = []
    for name, kind, length_kind in element.properties:
        if length_kind is None:
            fields.append((name, endian + kind))
        else:
            fields += [(f"{name}.length", endian + length_kind), (name, endian + kind, (length,))]
    if len({field[0] for field in fields}) < len(fields):
        raise _Unusual
    return np.dtype(fields)


def _check_length(element: _Element, have: int) -> None:
    if have < element.count:
        raise _Broken(
            f'is truncated: {have} of {element.count} records of "{element.name}" are there'
        )


def _read(body: bytes, elements: list[_Element], endian: str) -> Iterator[tuple[_Element, Any]]:
    """Records of each element of a binary file; lists must be of triangles."""
    for element in elements:
        if not element.properties:
            raise _Unusual
        record = _record(element, ENDIANS[endian], 3)
        have = len(body) // record.itemsize
        records = np.frombuffer(body, record, count=min(have, element.count))
        for name in record.names or ():
            if name.endswith(".length") and (records[name] != 3).any():
                raise _Unusual
        _check_length(element, have)
        yield element, records
        body = body[element.count * record.itemsize :]


def _read_text(body: bytes, elements: list[_Element]) -> Iterator[tuple[_Element, Any]]:
    """The same of a text file, as float64."""
    words = body.split()
    for element in elements:
        record = _record(element, "", 3)
        names = [
            (name, "f8", record[name].shape) if record[name].shape else (name, "f8")
            for name in record.names or ()
        ]
        width = sum(record[name].shape[0] if record[name].shape else 1 for name in record.names)
        have = len(words) // width if width else 0
        try:
            numbers = np.array(words[: min(have, element.count) * width], np.float64)
        except ValueError:
            raise _Unusual from None
        records = numbers.view(np.dtype(names))
        for name in record.names or ():
            if name.endswith(".length") and (records[name] != 3).any():
                raise _Unusual
        _check_length(element, have)
        yield element, records
        words = words[element.count * width :]


def _check_vertices(records: npt.NDArray[Any]) -> None:
    if not {"x", "y", "z"} <= set(records.dtype.names or ()):
        raise _Unusual
    points = np.stack([records[axis] for axis in "xyz"], axis=1)
    # Coordinates are rounded to float32, which has an end before float64 has. NaN is no less.
    bad = np.flatnonzero(~(np.abs(points) <= np.finfo(np.float32).max).all(axis=1))
    if bad.size:
        first = int(bad[0])
        raise _Broken(
            f"has a vertex that is not finite: vertex {first} is {points[first].tolist()}"
        )


def _check_faces(element: _Element, records: npt.NDArray[Any], vertices: int) -> None:
    for name, _, length_kind in element.properties:
        if length_kind is None or name not in {"vertex_index", "vertex_indices"}:
            continue
        indices = records[name]
        bad = np.argwhere((indices < 0) | (indices >= vertices))
        if bad.size:
            face, corner = bad[0]
            raise _Broken(
                f"has an index out of range: face {face} refers to vertex "
                f"{int(indices[face, corner])}, and there are {vertices}"
            )
