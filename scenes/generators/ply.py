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
) -> None:
    """Write vertices [V, 3], triangles [T, 3] and, if given, normals [V, 3] as float32, int32."""
    columns = [np.asarray(vertices, "<f4")]
    names = ["x", "y", "z"]
    if normals is not None:
        columns.append(np.asarray(normals, "<f4"))
        names += ["nx", "ny", "nz"]
    faces = np.asarray(triangles, "<i4")
    records = np.zeros(len(faces), np.dtype([("count", "u1"), ("vertices", "<i4", 3)]))
    records["count"], records["vertices"] = 3, faces
    header = ["ply", "format binary_little_endian 1.0"]
    header += [f"comment {comment}"] if comment else []
    header += [f"element vertex {len(columns[0])}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
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
