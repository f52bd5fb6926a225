"""Triangle meshes as binary little-endian PLY, the same bytes for the same arrays."""

from pathlib import Path

import numpy as np
import numpy.typing as npt


def write_ply(
    file: Path,
    vertices: npt.ArrayLike,
    triangles: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    comment: str = "",
    *,
    short: bool = False,
) -> None:
    """Write vertices [V, 3], triangles [T, 3] and, if given, normals [V, 3] as float32, int32.

    short: indices as uint16, for meshes of at most 65,536 vertices.
    """
    columns = [np.asarray(vertices, "<f4")]
    names = ["x", "y", "z"]
    if normals is not None:
        columns.append(np.asarray(normals, "<f4"))
        names += ["nx", "ny", "nz"]
    if short and len(columns[0]) > 1 << 16:
        raise ValueError(f"{len(columns[0])} vertices are too many for indices of 16 bits")
    index, index_name = ("<u2", "ushort") if short else ("<i4", "int")
    faces = np.asarray(triangles).astype(index)
    records = np.zeros(len(faces), np.dtype([("count", "u1"), ("vertices", index, 3)]))
    records["count"], records["vertices"] = 3, faces
    header = ["ply", "format binary_little_endian 1.0"]
    header += [f"comment {comment}"] if comment else []
    header += [f"element vertex {len(columns[0])}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}"]
    header += [f"property list uchar {index_name} vertex_indices", "end_header"]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(
        "\n".join(header).encode()
        + b"\n"
        + np.concatenate(columns, axis=1).tobytes()
        + records.tobytes()
    )


def quads(
    corners: npt.ArrayLike,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices and triangles of quadrilaterals [Q, 4, 3], wound as these; no vertex is shared."""
    points = np.asarray(corners, float).reshape(-1, 4, 3)
    first = 4 * np.arange(len(points))[:, None]
    triangles = (first + np.array([0, 1, 2, 0, 2, 3])).reshape(-1, 3)
    return points.reshape(-1, 3), triangles


def weld(
    corners: npt.ArrayLike, normals: npt.ArrayLike | None = None
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int64], npt.NDArray[np.float32] | None]:
    """Vertices, triangles and normals of corners [T, 3, 3], and normals of the same shape.

    Corners that are equal in float32, their normals too where there are any, become one vertex.
    """
    rows = np.asarray(corners, np.float32).reshape(-1, 3)
    if normals is not None:
        rows = np.concatenate([rows, np.asarray(normals, np.float32).reshape(-1, 3)], axis=1)
    # Zero has two signs, and np.unique compares values.
    rows, indices = np.unique(rows + np.float32(0.0), axis=0, return_inverse=True)
    triangles = indices.reshape(-1, 3).astype(np.int64)
    return rows[:, :3], triangles, rows[:, 3:] if normals is not None else None
