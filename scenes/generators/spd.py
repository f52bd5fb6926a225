"""Haines's databases tetra and teapot from Tachyon's example files, and a check of balls.

scenes/generators/README.md has the commands that fetch the files and run this.
"""

import argparse
import hashlib
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import weld, write_ply
from scipy.spatial import KDTree
from sphereflake import sphereflake

SCENES = Path(__file__).parents[1]
SOURCE = "tachyon-doc 0.99~b6+dsx-10"
FILES_SHA256 = {
    "balls.dat": "10b3aff836a76c478c262df2a75aea626cd80602ae1588900690528b06acb870",
    "tetra.dat": "c11fffff6eee12e0d395bd84cf0a5dbe6bbaee1ea657ceba8e6fb2b58d651274",
    "teapot.dat": "d685aa903d652f9c9fad8c41385ffef0082ec21c96a70c8d4cf26ee60eb09eab",
}
TEAPOT_PARTS = {
    "txt001": "light_tiles.ply",
    "txt002": "dark_tiles.ply",
    "txt003": "teapot.ply",
}
# Half a unit of the sixth digit in each of three coordinates below 1, rounded up.
WRITTEN_DIGITS = 1e-6

NUMBER = r"(\S+)"
VECTOR = rf"{NUMBER}\s+{NUMBER}\s+{NUMBER}"
TRIANGLE = re.compile(
    rf"^S?TRI\s+V0 {VECTOR}\s+V1 {VECTOR}\s+V2 {VECTOR}"
    rf"(?:\s+N0 {VECTOR}\s+N1 {VECTOR}\s+N2 {VECTOR})?\s+(?P<material>txt\d+)",
    re.MULTILINE,
)
SPHERE = re.compile(rf"SPHERE CENTER {VECTOR} RAD {NUMBER}")

Corners = npt.NDArray[np.float64]


def read(file: Path) -> str:
    """The text of one of the known files; anything else ends the program."""
    data = file.read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    if digest != FILES_SHA256.get(file.name):
        raise SystemExit(f"{file}: sha256 {digest}, expected {FILES_SHA256.get(file.name)}")
    return data.decode("ascii")


def triangles(text: str) -> dict[str, tuple[Corners, Corners | None]]:
    """By material, corners [T, 3, 3] of its triangles and their normals, None where it is flat."""
    flat: dict[str, list[list[float]]] = {}
    smooth: dict[str, list[list[float]]] = {}
    for match in TRIANGLE.finditer(text):
        numbers = match.groups()[:18]
        kind = flat if numbers[9] is None else smooth
        kept = [float(number) for number in numbers if number is not None]
        kind.setdefault(match["material"], []).append(kept)
    found: dict[str, tuple[Corners, Corners | None]] = {}
    for material, rows in flat.items():
        found[material] = (np.array(rows).reshape(-1, 3, 3), None)
    for material, rows in smooth.items():
        both = np.array(rows).reshape(-1, 2, 3, 3)
        found[material] = (both[:, 0], both[:, 1])
    return found


def write(file: Path, corners: Corners, normals: Corners | None) -> None:
    """Write triangles as a mesh whose equal corners are one vertex, wound along their normals."""
    if normals is not None:
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inwards = np.einsum("tx,tcx->t", faces, normals) < 0.0
        corners[inwards], normals[inwards] = corners[inwards, ::-1], normals[inwards, ::-1]
    points, indices, shading = weld(corners, normals)
    write_ply(file, points, indices, normals=shading, comment=SOURCE)
    print(f"{file}: {len(points)} vertices, {len(indices)} triangles")


def convert_tetra(file: Path) -> None:
    """Write scenes/tetra/assets/tetra.ply."""
    (corners, normals), *_ = triangles(read(file)).values()
    write(SCENES / "tetra" / "assets" / "tetra.ply", corners, normals)


def convert_teapot(file: Path) -> None:
    """Write scenes/teapot/assets/*.ply: the pot and the two colours of the board below it."""
    for material, (corners, normals) in triangles(read(file)).items():
        write(SCENES / "teapot" / "assets" / TEAPOT_PARTS[material], corners, normals)


def check_balls(file: Path) -> None:
    """Compare the spheres of the file with those that sphereflake.py makes; both in any order."""
    written = np.array(
        [[float(number) for number in found] for found in SPHERE.findall(read(file))]
    )
    made = np.concatenate(sphereflake(4))
    distances, partners = KDTree(written).query(made)
    if len(written) != len(made) or len(np.unique(partners)) != len(made):
        raise SystemExit(f"{file}: {len(written)} spheres, not the {len(made)} of sphereflake.py")
    largest = distances.max()
    print(f"{file}: {len(written)} spheres, those of sphereflake.py to within {largest:.1e}")
    if largest > WRITTEN_DIGITS:
        raise SystemExit("they are not the same")


def main() -> None:
    """Convert or check the files that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="+", help=", ".join(FILES_SHA256))
    steps = {"tetra": convert_tetra, "teapot": convert_teapot, "balls": check_balls}
    for file in parser.parse_args().file:
        if file.stem not in steps:
            raise SystemExit(f"{file}: not one of {', '.join(FILES_SHA256)}")
        steps[file.stem](file)


if __name__ == "__main__":
    main()
