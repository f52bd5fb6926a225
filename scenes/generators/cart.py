"""A farm cart of planks, with four spoked wheels, two axles and a pair of shafts.

Units are metres; x points backwards, the floor is z = 0. Every part is a closed solid that reaches
a little into its neighbours, as a joiner's would.

    python -m harness generate --scene cart
"""

import math
from pathlib import Path

import numpy as np
from ply import weld, write_ply
from solids import Corners, box, crease_normals, lathe, mirror, move, tube

CREASE_DEGREES = 40.0
BEVEL = 0.006

BED_LENGTH, BED_WIDTH, BED_HEIGHT = 1.9, 1.0, 0.62
FLOOR_PLANKS, SIDE_PLANKS = 8, 3
PLANK, GAP = 0.03, 0.012
SIDE_HEIGHT = 0.42
POSTS = (-0.86, -0.29, 0.29, 0.86)
"""Where along the bed the sides are held."""
TRACK = 0.66
"""Half the distance between the wheels of an axle."""
WHEELS = ((-0.62, 0.38), (0.62, 0.46))
"""Distance from the middle and radius of the front and the rear wheels."""


def planks() -> list[Corners]:
    """Bed, sides, ends, and the posts that hold them."""
    width = BED_WIDTH / FLOOR_PLANKS
    board = box((BED_LENGTH, width - GAP, PLANK), BEVEL)
    parts = [
        move(board, (0, (k + 0.5) * width - BED_WIDTH / 2, BED_HEIGHT)) for k in range(FLOOR_PLANKS)
    ]
    height = SIDE_HEIGHT / SIDE_PLANKS
    for k in range(SIDE_PLANKS):
        z = BED_HEIGHT + 0.025 + (k + 0.5) * height
        long_side = box((BED_LENGTH, PLANK, height - GAP), BEVEL)
        short_side = box((PLANK, BED_WIDTH - 0.02, height - GAP), BEVEL)
        for side in (-1, 1):
            parts.append(move(long_side, (0, side * (BED_WIDTH / 2 + 0.012), z)))
            parts.append(move(short_side, (side * (BED_LENGTH / 2 - 0.03), 0, z)))
    post = box((0.06, 0.05, SIDE_HEIGHT + 0.16), BEVEL)
    beam = box((BED_LENGTH, 0.07, 0.09), BEVEL)
    for side in (-1, 1):
        y, z = side * (BED_WIDTH / 2 + 0.045), BED_HEIGHT + SIDE_HEIGHT / 2
        parts += [move(post, (x, y, z)) for x in POSTS]
        parts.append(move(beam, (0, side * 0.3, BED_HEIGHT - 0.055)))
    return parts


def wheel(radius: float, segments: int, sides: int, spokes: int) -> tuple[Corners, Corners]:
    """Wood and iron of a wheel around the y axis."""
    wide, deep = 0.035, 0.075
    felloe = _rounded(radius - deep, radius - 0.012, -wide, wide, 0.008)
    tyre = _rounded(radius - 0.016, radius, -wide - 0.004, wide + 0.004, 0.003)
    hub = [
        *((0.0, -0.13), (0.05, -0.13), (0.058, -0.122), (0.062, -0.08), (0.085, -0.045)),
        *((0.09, 0.0), (0.085, 0.045), (0.062, 0.08), (0.058, 0.122), (0.05, 0.13), (0.0, 0.13)),
    ]
    wood = [lathe(felloe, segments), lathe(hub, segments // 2, closed=False)]
    steps = np.linspace(0.07, radius - deep + 0.015, 7)
    thickness = 0.017 + 0.007 * np.cos(np.linspace(-0.4 * math.pi, 0.8 * math.pi, 7))
    spoke = tube([(step, 0, 0) for step in steps], list(thickness), sides)
    wood += [move(spoke, degrees=360.0 * (k + 0.5) / spokes) for k in range(spokes)]
    iron = [lathe(tyre, segments)]
    for height in (-0.1, 0.1):
        band = _rounded(0.05, 0.068, height - 0.012, height + 0.012, 0.003)
        iron.append(lathe(band, segments // 2))
    upright = {"axis": (1, 0, 0), "degrees": 90.0}
    return tuple(move(np.concatenate(parts), **upright) for parts in (wood, iron))


def _rounded(
    inner: float, outer: float, low: float, high: float, cut: float
) -> list[tuple[float, float]]:
    """A rectangular profile for `lathe`, its corners cut off."""
    return [
        *((inner + cut, low), (outer - cut, low), (outer, low + cut), (outer, high - cut)),
        *((outer - cut, high), (inner + cut, high), (inner, high - cut), (inner, low + cut)),
    ]


def shafts(sides: int) -> list[Corners]:
    """Two bent poles from under the bed to the ground in front, and the bar between them."""
    t = np.linspace(0.0, 1.0, 25)
    x = -0.55 - 2.0 * t
    y = 0.30 + 0.10 * np.sin(math.pi * t) - 0.04 * t
    z = 0.53 - 0.55 * t**1.6 + 0.06 * np.sin(math.pi * t)
    radius = 0.034 - 0.010 * t
    z = np.maximum(z, radius + 0.001)
    pole = tube(np.stack([x, y, z], axis=1), list(radius), sides)
    bar = box((0.05, 0.72, 0.05), BEVEL)
    return [pole, mirror(pole, 1), move(bar, (-1.02, 0, 0.50))]


def bolts(sides: int) -> list[Corners]:
    """Round heads where planks are held."""
    angles = np.linspace(-0.2, math.pi / 2, 5)
    profile = [(0.0, -0.004), *((0.013 * math.cos(a), 0.009 * math.sin(a)) for a in angles[:-1])]
    head = lathe([*profile, (0.0, 0.009)], sides, closed=False)
    found = []
    height = SIDE_HEIGHT / SIDE_PLANKS
    for x in POSTS:
        for k in range(SIDE_PLANKS):
            z = BED_HEIGHT + 0.025 + (k + 0.5) * height
            outside = move(head, (x, -(BED_WIDTH / 2 + 0.07), z), axis=(1, 0, 0), degrees=90.0)
            found += [outside, mirror(outside, 1)]
    return found


def generate(wood_mesh: Path, iron_mesh: Path, *, segments: int, sides: int, spokes: int) -> None:
    """Write the wooden and the iron parts.

    segments: of a wheel's rim. sides: of round bars. spokes: of a wheel.
    """
    wood = [*planks(), *shafts(sides)]
    iron = bolts(sides)
    for x, radius in WHEELS:
        axle = box((0.09, 2 * TRACK - 0.2, 0.09), BEVEL)
        rod = tube(
            [(0, y, 0) for y in np.linspace(-TRACK - 0.15, TRACK + 0.15, 9)], [0.03] * 9, sides
        )
        wood.append(move(axle, (x, 0, radius)))
        iron.append(move(rod, (x, 0, radius)))
        block = box((0.12, 0.1, BED_HEIGHT - radius - 0.05), BEVEL)
        wooden, bound = wheel(radius, segments, sides, spokes)
        for side in (-1, 1):
            wood.append(move(block, (x, side * 0.3, (BED_HEIGHT + radius) / 2)))
            wood.append(move(wooden, (x, side * TRACK, radius)))
            iron.append(move(bound, (x, side * TRACK, radius)))
    for mesh, parts in ((wood_mesh, wood), (iron_mesh, iron)):
        # Normals part by part: where two parts touch there is an edge.
        normals = np.concatenate([crease_normals(part, CREASE_DEGREES) for part in parts])
        points, triangles, shading = weld(np.concatenate(parts), normals)
        write_ply(mesh, points, triangles, normals=shading, comment="cart")
