"""A stadium: a pitch with its lines, stands of many steps around it, a wall behind and a roof.

Units are metres; the pitch lies in the plane z = 0 around the origin.

    python -m harness generate --scene teapot-stadium
"""

import math
from pathlib import Path

import numpy as np
from ply import weld, write_ply
from solids import Corners, box, lathe, move, skin

PITCH_LENGTH, PITCH_WIDTH = 105.0, 68.0
LINE_WIDTH, LINE_HEIGHT = 0.12, 0.004
CIRCLE_RADIUS = 9.15
BOX_DEPTH, BOX_WIDTH = 16.5, 40.32
"""International Football Association Board, Laws of the Game, law 1."""

INNER_LENGTH, INNER_WIDTH = 74.0, 54.0
"""Half axes of the front edge of the stands."""
ROUNDNESS = 3.0
"""Exponent of the superellipse that the stands follow: 2 is an ellipse."""
STEP_DEPTH, PARAPET = 0.9, 1.4
LOWER_SLOPE, UPPER_SLOPE = 0.45, 0.75
"""Rise over run: higher rows are steeper, so that all see the pitch."""


def ring(profile: list[tuple[float, float]], segments: int) -> Corners:
    """A band around the pitch: a profile of (distance behind the front edge, height), outside up.

    Seen from the pitch the profile runs upwards.
    """
    angles = 2.0 * math.pi * np.arange(segments + 1) / segments
    angles[-1] = 0.0
    c, s = np.cos(angles), np.sin(angles)
    power = 2.0 / ROUNDNESS
    x, y = np.sign(c) * np.abs(c) ** power, np.sign(s) * np.abs(s) ** power
    rows = []
    for distance, height in profile:
        row = np.stack(
            [(INNER_LENGTH + distance) * x, (INNER_WIDTH + distance) * y, 0 * x + height], axis=1
        )
        rows.append(row)
    # Facing inwards, the columns run clockwise.
    return skin(np.array(rows)[:, ::-1])


def stand(distance: float, height: float, steps: int, slope: float) -> list[tuple[float, float]]:
    """Profile of a parapet, which starts at a height, and of the steps behind it."""
    profile = [(distance, height), (distance, height + PARAPET)]
    profile += [(distance + 0.2, height + PARAPET), (distance + 0.2, height + 0.5)]
    for _ in range(steps):
        behind, above = profile[-1]
        profile += [(behind + STEP_DEPTH, above), (behind + STEP_DEPTH, above + slope * STEP_DEPTH)]
    return profile


def lines() -> list[Corners]:
    """White lines of the pitch, thin solids on the grass."""

    def line(x0: float, y0: float, x1: float, y1: float) -> Corners:
        size = (abs(x1 - x0) + LINE_WIDTH, abs(y1 - y0) + LINE_WIDTH, 2 * LINE_HEIGHT)
        return move(box(size), ((x0 + x1) / 2, (y0 + y1) / 2, 0.0))

    half, side = PITCH_LENGTH / 2, PITCH_WIDTH / 2
    found = [line(0, -side, 0, side)]
    for sign in (-1, 1):
        found.append(line(-half, sign * side, half, sign * side))
        found.append(line(sign * half, -side, sign * half, side))
        edge = sign * (half - BOX_DEPTH)
        found.append(line(edge, -BOX_WIDTH / 2, edge, BOX_WIDTH / 2))
        for other in (-1, 1):
            y = other * BOX_WIDTH / 2
            found.append(line(min(edge, sign * half), y, max(edge, sign * half), y))
    inner, outer = CIRCLE_RADIUS - LINE_WIDTH / 2, CIRCLE_RADIUS + LINE_WIDTH / 2
    section = [(inner, -LINE_HEIGHT), (outer, -LINE_HEIGHT)]
    found.append(lathe([*section, (outer, LINE_HEIGHT), (inner, LINE_HEIGHT)], 256))
    return found


def generate(
    lower: Path, upper: Path, roof: Path, line_mesh: Path, *, segments: int, steps: int
) -> None:
    """Write the two tiers of the stands, the roof and the lines.

    segments: around the pitch. steps: rows of seats of each tier.
    """
    lower_profile = stand(0.0, 0.0, steps, LOWER_SLOPE)
    distance, height = lower_profile[-1]
    upper_profile = stand(distance, height, steps, UPPER_SLOPE)
    distance, height = upper_profile[-1]
    upper_profile += [(distance + 3.0, height), (distance + 3.0, height + 9.0)]
    roof_profile = [(distance + 3.0, height + 9.0), (distance - 16.0, height + 12.0)]
    roof_profile += [(distance - 16.0, height + 13.0), (distance + 3.0, height + 10.0)]
    for mesh, profile in ((lower, lower_profile), (upper, upper_profile), (roof, roof_profile)):
        write_ply(mesh, *weld(ring(profile, segments))[:2], comment=mesh.stem)
    write_ply(line_mesh, *weld(np.concatenate(lines()))[:2], comment=line_mesh.stem)
