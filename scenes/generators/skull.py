"""The skull: writes scenes/skull/assets/skull.ply from a volume in Debian's libcgal-demo.

scenes/skull/README.md has the commands that fetch the volume and run this.
"""

import argparse
import hashlib
from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import write_ply
from skimage.measure import marching_cubes

ASSETS = Path(__file__).parents[1] / "skull" / "assets"
VOLUME_SHA256 = "7a9147c819e426fbd7bf4f0ed5ddac799e54376f64260ef4f650f29e3aa5d4c4"
ISO_VALUE = 2.9
HEADER_BYTES = 256


def read_inr(file: Path) -> tuple[npt.NDArray[np.float32], tuple[float, float, float]]:
    """Values [Z, Y, X] and voxel spacing in that order, in millimetres, of an INRIMAGE-4 volume."""
    data = file.read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    if digest != VOLUME_SHA256:
        raise SystemExit(f"{file}: sha256 {digest}, expected {VOLUME_SHA256}")
    lines = data[:HEADER_BYTES].decode("ascii").splitlines()
    header = dict(line.split("=", 1) for line in lines if "=" in line)
    size = [int(header[f"{axis}DIM"]) for axis in "ZYX"]
    spacing = (float(header["VZ"]), float(header["VY"]), float(header["VX"]))
    return np.frombuffer(data, "<f4", offset=HEADER_BYTES).reshape(size), spacing


def vertex_normals(
    vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.int64]
) -> npt.NDArray[np.float64]:
    """Area-weighted mean of the normals of the faces around each vertex, normalised. [V, 3]."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(sums, triangles[:, corner], faces)
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)


def main() -> None:
    """Read the volume that the command line names and write the mesh."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("volume", type=Path, help="skull_2.9.inr")
    parser.add_argument("--output", type=Path, default=ASSETS / "skull.ply")
    arguments = parser.parse_args()
    volume, spacing = read_inr(arguments.volume)
    # One voxel of padding closes the surface where the volume cuts it.
    padded = np.pad(volume.astype(np.float64), 1, constant_values=float(volume.min()))
    vertices, triangles, _, _ = marching_cubes(padded, ISO_VALUE, spacing=spacing)
    vertices, triangles = vertices[:, ::-1].astype(np.float64), triangles.astype(np.int64)
    tips = vertices[triangles]
    if np.einsum("tx,tx->", tips[:, 0], np.cross(tips[:, 1], tips[:, 2])) < 0.0:
        triangles = triangles[:, ::-1]
    write_ply(
        arguments.output,
        vertices,
        triangles,
        normals=vertex_normals(vertices, triangles),
        comment=f"libcgal-demo 5.5.1-2, skull_2.9.inr, marching cubes at {ISO_VALUE}, millimetres",
    )
    print(f"{arguments.output}: {len(vertices)} vertices, {len(triangles)} triangles")


if __name__ == "__main__":
    main()
