"""What the gate calls agreement: its settings, and what it holds the images of a scene to."""

from __future__ import annotations

from dataclasses import dataclass

from harness.statistics.tiles import FAMILY_LEVEL, TILE, sidak_level
from harness.tables.read import SceneJob

VISIBLE = 0.10
"""Relative error of the median tile that the tile test must be able to see.

A test without power rejects nothing; that is no pass.
"""
FAR = 0.1
"""Pixels by which a picture may lie off the truth's: half a pixel is what mistakes come to."""
TESTS = 6
"""Tests of one tracer that are not of tiles: bias, seeds and place; against the baseline bias,
variance and speed."""


@dataclass(frozen=True, slots=True)
class GateSettings:
    """What counts as agreement; the section `gate` of a run's settings."""

    delta: float = 0.005
    """the 90 % interval of the relative bias must lie within plus or minus this"""
    caustic_delta: float = 0.01
    """the same where a caustic carries most of the variance in a few pixels"""
    alpha: float = FAMILY_LEVEL
    """chance that a check rejects any right image: half of it is the tiles', half the rest's"""
    tile: int = TILE
    """edge of a tile in pixels"""
    variance_margin: float = 1.25
    """the ratio of a variance to the baseline's must be proven to lie below this"""
    speed_margin: float = 0.1
    """a speed is the same where its ratio to the baseline's is proven to be 1 to within this"""

    def strict(self, tests: int) -> float:
        """Level of each of the tests that are not of tiles, `tests` of them in the run."""
        return sidak_level(max(tests, 1), 0.5 * self.alpha)

    def tile_level(self, tiles: int) -> float:
        """Level of the test of each of a run's tiles."""
        return sidak_level(max(tiles, 1), 0.5 * self.alpha)


def settings_of(jobs: list[SceneJob]) -> GateSettings:
    """The gate's settings as a run's provenance recorded them, defaults where it did not."""
    recorded = jobs[0].provenance.get("config", {}) if jobs else {}
    return GateSettings(**recorded.get("gate", {}))


@dataclass(frozen=True, slots=True)
class Bound:
    """What images of one scene are held to."""

    delta: float
    strict: float
    """level of each test that is not of a tile"""
    tile: int
