"""What the look at a PLY file finds, and what it leaves to Mitsuba."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.scene.ply import check_ply

HEADER = """ply
format {} 1.0
comment made for a test
element vertex 4
property double x
property double y
property double z
property uchar red
element face 2
property list uint8 uint vertex_indices
property float quality
end_header
"""
ENDIANS = {"binary_little_endian": "<", "binary_big_endian": ">"}
POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def binary(form: str, points: np.ndarray = POINTS, faces: np.ndarray = FACES) -> bytes:
    """A mesh with a property beside the coordinates and one beside the indices."""
    endian = ENDIANS[form]
    vertices = np.zeros(len(points), [("p", endian + "f8", 3), ("red", "u1")])
    vertices["p"] = points
    triangles = np.zeros(
        len(faces), [("n", "u1"), ("i", endian + "u4", faces.shape[1]), ("q", endian + "f4")]
    )
    triangles["n"], triangles["i"] = faces.shape[1], faces
    return HEADER.format(form).encode() + vertices.tobytes() + triangles.tobytes()


def text(points: np.ndarray = POINTS, faces: np.ndarray = FACES) -> bytes:
    lines = [f"{x} {y} {z} 255" for x, y, z in points]
    lines += [f"{len(face)} {' '.join(map(str, face))} 0.5" for face in faces]
    return (HEADER.format("ascii") + "\n".join(lines) + "\n").encode()


@pytest.fixture
def check(tmp_path: Path) -> Any:
    """`check_ply` of some bytes."""

    def look(data: bytes) -> str | None:
        file = tmp_path / "mesh.ply"
        file.write_bytes(data)
        return check_ply(file)

    return look


@pytest.mark.parametrize("form", [*ENDIANS, "ascii"])
def test_a_sound_file_passes_in_every_format(check: Any, form: str):
    assert check(text() if form == "ascii" else binary(form)) is None


@pytest.mark.parametrize("form", [*ENDIANS, "ascii"])
def test_a_vertex_that_is_no_number_is_named_in_every_format(check: Any, form: str):
    points = POINTS.copy()
    points[2, 1] = np.nan
    data = text(points) if form == "ascii" else binary(form, points)
    message = '"mesh.ply" has a vertex that is not finite: vertex 2 is [1.0, nan, 0.0]'
    assert check(data) == message


@pytest.mark.parametrize("form", [*ENDIANS, "ascii"])
def test_an_index_out_of_range_is_named_in_every_format(check: Any, form: str):
    faces = FACES.copy()
    faces[1, 2] = 4
    data = text(faces=faces) if form == "ascii" else binary(form, faces=faces)
    message = '"mesh.ply" has an index out of range: face 1 refers to vertex 4, and there are 4'
    assert check(data) == message


def test_a_coordinate_beyond_float32_is_not_finite(check: Any):
    points = POINTS.copy()
    points[0, 0] = 1e60
    found = check(binary("binary_little_endian", points))
    assert found is not None and "vertex 0 is [1e+60, 0.0, 0.0]" in found, found


@pytest.mark.parametrize("cut", [1, 5, 20, 40, 60, 100])
@pytest.mark.parametrize("form", list(ENDIANS))
def test_a_file_that_is_cut_anywhere_is_truncated(check: Any, form: str, cut: int):
    found = check(binary(form)[:-cut])
    assert found is not None and found.startswith('"mesh.ply" is truncated: '), (cut, found)


def test_faces_may_come_before_vertices(check: Any):
    lines = HEADER.format("ascii").splitlines()
    vertex, face = lines.index("element vertex 4"), lines.index("element face 2")
    header = [*lines[:vertex], *lines[face:-1], *lines[vertex:face], lines[-1]]
    body = text().decode().splitlines()[len(lines) :]
    data = "\n".join([*header, *body[4:], *body[:4], ""]).encode()
    assert check(data) is None
    assert "face 1 refers to vertex 4" in check(data.replace(b"3 0 2 3 0.5", b"3 0 2 4 0.5"))


@pytest.mark.parametrize("form", [*ENDIANS, "ascii"])
def test_polygons_are_left_to_mitsuba(check: Any, form: str):
    quad = np.array([[0, 1, 2, 9], [0, 1, 2, 9]])
    data = text(faces=quad) if form == "ascii" else binary(form, faces=quad)
    assert check(data) is None


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"property uchar red", b"property colour red"),
        (b"format ascii 1.0", b"format morse 1.0"),
        (b"property double x", b"property double u"),
        (b"property double x", b"property double y"),
        (b"element vertex 4", b"element vertex four"),
    ],
)
def test_an_unusual_header_is_left_to_mitsuba(check: Any, old: bytes, new: bytes):
    assert check(text().replace(old, new)) is None
