"""Images of one tracer set against the truth: mean, tiles, seeds and place."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from harness.bounds import FAR, VISIBLE, Bound
from harness.statistics.bias import (
    GATE_LEVEL,
    Equivalence,
    Verdict,
    image_means,
    judge_equivalence,
    relative_difference,
)
from harness.statistics.independence import strongest_correlation
from harness.statistics.metrics import Image, Truth
from harness.statistics.registration import find_shift
from harness.statistics.tiles import TileTest, compare_tiles, rounding_bound, sidak_level


@dataclass(frozen=True, slots=True)
class Agreement:
    """What images say beside the truth, before the level of their tiles is known."""

    bias: Equivalence
    tiles: TileTest
    note: str
    """what is wrong with the images as a whole; empty where nothing is"""

    def verdict(self, level: float) -> Verdict:
        """The worst of all verdicts, `level` being that of a tile's test."""
        found = {self.bias.verdict, tile_verdict(self.tiles, level)}
        return worst({*found, Verdict.FAIL} if self.note else found)


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """FAIL before NOT ENOUGH SAMPLES before PASS."""
    return max(verdicts, key=list(Verdict).index)


def tile_verdict(tiles: TileTest, level: float) -> Verdict:
    """FAIL where a tile is rejected; a test that could not see an error of VISIBLE is no PASS."""
    if (tiles.p < level).any():
        return Verdict.FAIL
    # A black image has no tile of which an error could be a share: nothing differs.
    return Verdict.NOT_ENOUGH_SAMPLES if tiles.detectable(level) > VISIBLE else Verdict.PASS


def compare_images(
    images: Image, spp: int, truth: Truth, bound: Bound, *, independent: bool = True
) -> Agreement:
    """Set finite images [K >= 2, h, w, 3] of `spp` samples a pixel against the truth.

    independent: whether seeds must differ; where the answer is known every sample may bring it.
    """
    means, reference = image_means(images), image_means(truth.batches)
    interval = relative_difference(means, reference, GATE_LEVEL)
    strict = relative_difference(means, reference, 1.0 - bound.strict)
    bias = judge_equivalence(interval, bound.delta, truth.batches.shape[0], strict)
    tiles = compare_tiles(images, truth.batches, rounding_bound(spp), bound.tile)
    note = _dependence(images, truth, bound.strict) if independent else ""
    return Agreement(bias, tiles, note or _displacement(images, truth, bound.strict))


def _dependence(images: Image, truth: Truth, strict: float) -> str:
    """Why the spread of images over their seeds means nothing, empty if it does."""
    if not (truth.mean_variance > 0.0).any():
        return ""
    if len({image.tobytes() for image in images}) < len(images):
        return "images of different seeds are equal, so that their spread means nothing"
    found = strongest_correlation(images) if len(images) > 2 else None
    if found is None or found.p >= sidak_level(found.pairs, strict):
        return ""
    return (
        f"images {found.first} and {found.second} share noise (correlation {found.value:+.3f}, "
        f"p {found.p:.1e}), so that their spread means too little"
    )


def _displacement(images: Image, truth: Truth, strict: float) -> str:
    """Where the picture lies if it is proven to lie elsewhere, else empty."""
    shift = find_shift(images, truth)
    if shift is None:
        return ""
    for estimate, direction in ((shift.right, "right"), (shift.down, "down")):
        found = estimate.interval(1.0 - 0.5 * strict)
        if found.lower > FAR or found.upper < -FAR:
            return f"the picture lies {found.value:+.2f} pixels {direction} of the truth's"
    return ""
