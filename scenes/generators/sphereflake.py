"""The sphereflake: each sphere carries nine of a third its radius.

E. Haines, "A Proposal for Standard Graphics Environments", IEEE Computer Graphics and Applications
7 (11), 1987; its database "balls" is the flake of four generations of children, 7,381 spheres.

    python -m harness generate --scene sphereflake

`spd.py` checks what is made here against the spheres of another program's file.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

Vectors = npt.NDArray[np.float64]

CHILDREN = 9
SHRINKING = 1.0 / 3.0
FIRST_RADIUS = 0.5
# Sine of the angle to the z axis that is rounding: of a few operations on numbers near 1.
ALIGNED = 1e-12


def child_directions() -> Vectors:
    """Directions [9, 3] to the children of a sphere whose axis is +z.

    Three trios, a third of a turn apart; a trio are the edge midpoints of a cube around one of its
    corners, tilted until that corner is level.
    """
    half = math.sqrt(0.5)
    trio = np.array([(half, half, 0.0), (half, 0.0, -half), (0.0, half, -half)])
    tilted = trio @ rotation((half, -half, 0.0), math.asin(2.0 / math.sqrt(6.0))).T
    turns = [rotation((0.0, 0.0, 1.0), 2.0 * math.pi * k / 3.0) for k in range(3)]
    return np.concatenate([tilted @ turn.T for turn in turns])


def rotation(axis: Sequence[float], angle: float) -> Vectors:
    """Matrix [3, 3] of the turn by `angle` about a unit vector (Rodrigues)."""
    x, y, z = axis
    cross = np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


def from_z(axis: Vectors) -> Vectors:
    """Matrix [3, 3] of the shortest turn that brings +z to a unit vector.

    All turns to -z are as short; it is the half turn about y, as in Haines's program.
    """
    turning = np.array([-axis[1], axis[0], 0.0])
    length = float(np.linalg.norm(turning))
    if length < ALIGNED:
        return np.eye(3) if axis[2] > 0.0 else rotation((0.0, 1.0, 0.0), math.pi)
    return rotation(turning / length, math.acos(min(max(float(axis[2]), -1.0), 1.0)))


def sphereflake(generations: int) -> list[Vectors]:
    """Centres and radii [9^k, 4] of each generation k of a flake around the origin.

    Children follow their parents' order.
    """
    directions = child_directions()
    axes = np.array([(0.0, 0.0, 1.0)])
    spheres = [np.array([(0.0, 0.0, 0.0, FIRST_RADIUS)])]
    for _ in range(generations):
        axes = np.concatenate([directions @ from_z(axis).T for axis in axes])
        parents = np.repeat(spheres[-1], CHILDREN, axis=0)
        radii = SHRINKING * parents[:, 3:]
        centres = parents[:, :3] + (parents[:, 3:] + radii) * axes
        spheres.append(np.concatenate([centres, radii], axis=1))
    return spheres


def generate(fragment: Path, *, generations: int, materials: Sequence[str]) -> None:
    """Write the flake as Mitsuba shapes, for a scene to include.

    materials: ids of the BSDF of each generation, the last for all that follow.
    """
    lines = ['<scene version="3.0.0">']
    for generation, spheres in enumerate(sphereflake(generations)):
        material = materials[min(generation, len(materials) - 1)]
        for x, y, z, radius in spheres:
            # 9 digits tell every float32; rounding first makes a zero of what is almost one.
            centre = ", ".join(f"{round(value, 12) + 0.0:.9g}" for value in (x, y, z))
            lines.append(
                f'<shape type="sphere"><point name="center" value="{centre}"/>'
                f'<float name="radius" value="{radius:.9g}"/><ref id="{material}"/></shape>'
            )
    fragment.write_text("\n".join([*lines, "</scene>\n"]), encoding="ascii")
