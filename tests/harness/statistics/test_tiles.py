"""The tile test: level under the null, power against planted errors, degenerate tiles."""

import numpy as np
import pytest
from scipy import stats

from harness.statistics.tiles import (
    compare_tiles,
    rounding_bound,
    sidak_level,
    tile_means,
    welch_test,
)

SHAPE = (64, 64, 3)


def stack(random: np.random.Generator, mean: np.ndarray, count: int, spp: int) -> np.ndarray:
    """Gamma-distributed pixels whose single samples vary as much as their mean."""
    return random.gamma(spp, mean / spp, (count, *mean.shape)).astype(np.float32).astype(float)


def test_welch_equals_scipy():
    random = np.random.default_rng(1)
    a, b = random.normal(0.0, 1.0, (20, 50)), random.normal(0.2, 3.0, (16, 50))
    expected = stats.ttest_ind(a, b, axis=0, equal_var=False).pvalue
    np.testing.assert_allclose(welch_test(a, b, rounding=0.0), expected, rtol=1e-9)


def test_p_values_of_equal_images_are_uniform():
    random = np.random.default_rng(2)
    mean = random.uniform(0.1, 1.0, SHAPE)
    p = [
        compare_tiles(stack(random, mean, 16, 16), stack(random, mean, 16, 32)).p.ravel()
        for _ in range(12)
    ]
    values = np.concatenate(p)
    assert stats.kstest(values, "uniform").pvalue > 1e-3, np.histogram(values, 10)[0]


def test_the_null_is_rejected_no_more_often_than_stated():
    random = np.random.default_rng(3)
    level, runs, tiles = 0.05, 400, 256
    # Tile means of skewed pixels: 64 of them, each of exponential samples.
    p = [
        welch_test(random.gamma(64.0, size=(16, tiles)), random.gamma(256.0, 0.25, (16, tiles)))
        for _ in range(runs)
    ]
    rejected = sum((values < sidak_level(tiles, level)).any() for values in p)
    bound = stats.binom.isf(1e-3, runs, level)
    assert rejected <= bound, (rejected, bound)


@pytest.mark.parametrize("seeds", [3, 8, 16])
def test_the_far_tail_holds_with_few_seeds(seeds: int):
    random = np.random.default_rng(10)
    level, tests = 1e-4, 400_000
    rejected = 0
    for _ in range(4):
        p = welch_test(
            np.sqrt(2.0) * random.standard_normal((seeds, tests // 4)),
            random.standard_normal((16, tests // 4)),
        )
        rejected += int((p < level).sum())
    bound = stats.binom.isf(1e-4, tests, level)
    assert rejected <= bound, (rejected, bound)


def test_a_planted_ten_per_cent_tile_is_rejected():
    random = np.random.default_rng(4)
    mean = random.uniform(0.2, 1.0, SHAPE)
    changed = mean.copy()
    changed[16:24, 40:48] *= 1.1
    level = sidak_level(2880)
    for _ in range(10):
        found = compare_tiles(stack(random, changed, 16, 32), stack(random, mean, 16, 64))
        p, row, column = found.smallest
        assert (row, column) == (2, 5), found.p
        assert p < level, (p, level)
        assert (found.p < level).sum() == 1


def test_a_one_per_cent_tile_is_beyond_the_test_and_it_says_so():
    random = np.random.default_rng(5)
    mean = random.uniform(0.2, 1.0, SHAPE)
    found = compare_tiles(stack(random, mean, 16, 32), stack(random, mean, 16, 64))
    assert 0.01 < found.detectable(sidak_level(2880)) < 0.1


def test_the_detectable_error_is_rejected_half_of_the_time():
    random = np.random.default_rng(6)
    mean = np.full(SHAPE, 0.5)
    level = sidak_level(1000)
    size = compare_tiles(stack(random, mean, 16, 8), stack(random, mean, 16, 32)).detectable(level)
    found = compare_tiles(stack(random, (1 + size) * mean, 16, 8), stack(random, mean, 16, 32))
    assert 0.25 < (found.p < level).mean() < 0.75


def test_tiles_without_variance_agree_within_rounding_and_nowhere_else():
    bound = rounding_bound(64)
    truth = np.ones((4, 3))
    shifts = np.array([0.0, 0.9 * bound, 1.1 * bound])
    p = welch_test(truth + shifts, truth, bound)
    np.testing.assert_array_equal(p, [1.0, 1.0, 0.0])


def test_black_tiles_agree_with_black_and_nothing_else():
    p = welch_test(np.array([[0.0, 1e-20]] * 4), np.zeros((4, 2)))
    np.testing.assert_array_equal(p, [1.0, 0.0])


def test_rounding_noise_is_no_evidence():
    random = np.random.default_rng(8)
    # Two float32 films of a constant 0.7: exact in one, accumulated sample by sample in the other.
    total = np.float32(0.0)
    for _ in range(256):
        total += np.float32(0.7)
    accumulated = float(total / np.float32(256.0))
    noise = 1e-9 * random.standard_normal((16, 100))
    p = welch_test(accumulated + noise, np.full((16, 100), float(np.float32(0.7))))
    assert p.min() == 1.0, (accumulated, p.min())
    strict = welch_test(accumulated + noise, np.full((16, 100), float(np.float32(0.7))), 0.0)
    assert strict.max() < 1e-6


def test_no_input_gives_a_nan():
    random = np.random.default_rng(9)
    a, b = random.normal(size=(4, 6)), random.normal(size=(4, 6))
    a[:, 0], b[:, 0] = 0.0, 0.0
    a[:, 1], b[:, 1] = 3.0, 3.0
    a[:, 2] = 1.0
    a[1, 3], b[2, 4] = np.nan, np.inf
    b[:, 5] = 1e-300
    with np.errstate(all="ignore"):
        p = welch_test(a, b)
    assert np.isfinite(p).all(), p
    assert p[3] == p[4] == 0.0


def test_images_that_are_no_multiple_of_a_tile_keep_their_edges():
    image = np.arange(10 * 20 * 3, dtype=float).reshape(1, 10, 20, 3)
    found = tile_means(image)
    assert found.shape == (1, 2, 3)
    expected = (image[0, 8:, 16:] @ np.array([0.212671, 0.715160, 0.072169])).mean()
    assert found[0, 1, 2] == pytest.approx(expected)


def test_sidak_over_one_test_is_the_level():
    assert sidak_level(1, 0.05) == pytest.approx(0.05)
    assert 1.0 - (1.0 - sidak_level(3000, 0.01)) ** 3000 == pytest.approx(0.01)
    with pytest.raises(ValueError, match="at least 1"):
        sidak_level(0)
