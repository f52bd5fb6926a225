"""The measured Cornell box: writes scenes/cornell-box/assets/*.ply.

Coordinates, in millimetres: Cornell University Program of Computer Graphics, "Cornell Box Data",
https://www.graphics.cornell.edu/online/box/data.html. All faces are wound towards the viewer's
side: walls inwards, blocks outwards, the light down. The light hangs half a millimetre below the
ceiling, so that the two do not coincide.

    python scenes/generators/cornell_box.py
"""

from pathlib import Path

import numpy as np
from ply import quads, write_ply

ASSETS = Path(__file__).parents[1] / "cornell-box" / "assets"

FLOOR = [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]
CEILING = [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]
BACK_WALL = [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]
GREEN_WALL = [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]
RED_WALL = [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]
LIGHT_HEIGHT = 548.8 - 0.5
LIGHT = [(x, LIGHT_HEIGHT, z) for x, z in ((343, 227), (343, 332), (213, 332), (213, 227))]
SHORT_BLOCK = (165.0, [(130, 65), (82, 225), (240, 272), (290, 114)])
TALL_BLOCK = (330.0, [(423, 247), (265, 296), (314, 456), (472, 406)])


def block(height: float, base: list[tuple[float, float]]) -> np.ndarray:
    """Top and four sides [5, 4, 3] of a block that stands on the floor."""
    top = [(x, height, z) for x, z in base]
    sides = []
    for (x0, z0), (x1, z1) in zip(base, base[1:] + base[:1], strict=True):
        sides.append([(x0, 0, z0), (x1, 0, z1), (x1, height, z1), (x0, height, z0)])
    return np.array([top, *sides], float)


def meshes() -> dict[str, np.ndarray]:
    """Quadrilaterals [Q, 4, 3] of each asset, by file name."""
    return {
        "white_walls": np.array([FLOOR, CEILING, BACK_WALL], float),
        "green_wall": np.array([GREEN_WALL], float),
        "red_wall": np.array([RED_WALL], float),
        "light": np.array([LIGHT], float),
        "short_block": block(*SHORT_BLOCK),
        "tall_block": block(*TALL_BLOCK),
    }


def main(folder: Path = ASSETS) -> None:
    """Write the assets into `folder`."""
    for name, corners in meshes().items():
        write_ply(folder / f"{name}.ply", *quads(corners))


if __name__ == "__main__":
    main()
