"""Meshes of Debian's libcgal-demo: writes the assets of bunny, head and armadillo.

scenes/generators/README.md has the commands that fetch the files and run this.
"""

import argparse
import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from ply import write_ply

SCENES = Path(__file__).parents[1]
SOURCE = "libcgal-demo 5.5.1-2"


@dataclass(frozen=True, slots=True)
class Scan:
    """A file of the package, and the asset that is made of it."""

    asset: str
    sha256: str


SCANS = {
    "bunny00.off": Scan(
        "bunny/assets/bunny.ply",
        "ab651cb04955c161efaeb079035a1e5e1f0e0d1f816a2df67beaea68f393ff2b",
    ),
    "mannequin-devil.off": Scan(
        "head/assets/head.ply",
        "9424b7132b58766984051fb7757543e88972f91fe7e9565d4e5b715b204f74a5",
    ),
    "armadillo.off": Scan(
        "armadillo/assets/armadillo.ply",
        "6f7f3ca1abc506569466b72f2f59d49493a284e7376d7a7e23c08115ec8cec4e",
    ),
}


def read_off(file: Path) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices [V, 3] and triangles [T, 3] of a known OFF file; anything else ends the program."""
    data = file.read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    if file.name not in SCANS or digest != SCANS[file.name].sha256:
        raise SystemExit(f"{file}: sha256 {digest} is none of the files that are known")
    words = data.decode("ascii").split()
    vertex_count, face_count = int(words[1]), int(words[2])
    end = 4 + 3 * vertex_count
    vertices = np.array(words[4:end], float).reshape(-1, 3)
    faces = np.array(words[end:], np.int64).reshape(face_count, 4)
    return vertices, faces[:, 1:]


def main() -> None:
    """Convert the files that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="+", help=", ".join(SCANS))
    for file in parser.parse_args().file:
        vertices, triangles = read_off(file)
        asset = SCENES / SCANS[file.name].asset
        write_ply(asset, vertices, triangles, comment=f"{SOURCE}, {file.name}", short=True)
        print(f"{asset}: {len(vertices)} vertices, {len(triangles)} triangles")


if __name__ == "__main__":
    main()
