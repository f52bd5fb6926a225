"""Agreement between tracers: what counts as a difference, and which rays are compared."""

from itertools import pairwise

import numpy as np
import pytest

from harness.eye_rays import SAME_DISTANCE, Seen, count_differences
from harness.rays.agreement import LEAST_RUNS, LONGEST_RUN, Sight, compare, evenly
from harness.tracers.rays import NONE

MISS = (np.inf, int(NONE))


def seen(*hits: tuple[float, int]) -> Seen:
    t, primitive = zip(*hits, strict=True)
    return Seen(np.array(t, np.float32), np.array(primitive, np.uint32))


@pytest.mark.parametrize("wanted", [1, 7, 4096, 2**18, 2**20])
def test_a_share_has_so_many_rays_from_all_over_the_file(wanted: int):
    count = 2**20
    places = evenly(count, wanted)
    assert len(places) == wanted and places[0] == 0 and places[-1] < count
    assert (np.diff(places) > 0).all()
    # No gap is longer than the distance of two runs.
    runs = -(-wanted // min(LONGEST_RUN, max(1, wanted // LEAST_RUNS)))
    assert np.diff(np.append(places, count)).max() <= -(-count // runs)


def test_of_counts_that_are_powers_of_two_the_smaller_is_part_of_the_larger():
    count = 2**22
    shares = [set(evenly(count, 2**k).tolist()) for k in (6, 8, 10, 12, 18, 20)]
    for smaller, larger in pairwise(shares):
        assert smaller <= larger


def test_a_share_of_more_than_all_is_all():
    assert np.array_equal(evenly(5, 9), np.arange(5))


def test_neighbours_at_one_distance_agree_and_other_surfaces_do_not():
    one = seen((1.0, 3), (1.0, 3), MISS, (2.0, 5), MISS)
    two = seen((1.0, 3), (1.0001, 4), MISS, (2.1, 6), (1.0, 1))
    share = compare(one, two, any_hit=False)
    assert (share.count, share.rays, share.ppm) == (2, 5, 4e5)


def test_where_any_hit_will_do_only_having_one_counts():
    one = seen((0.0, int(NONE)), MISS, MISS)
    two = seen((7.5, 3), MISS, (1.0, 2))
    assert compare(one, two, any_hit=True).count == 1


def test_a_count_of_differences_is_that_of_every_ray_by_itself():
    """Against the definition, on rays of which many differ in every way there is."""
    random = np.random.default_rng(8)
    t = random.choice([0.0, 1.0, 1.0005, 1.01, 3e38, np.inf], (2, 5000)).astype(np.float32)
    primitive = random.integers(0, 3, (2, 5000)).astype(np.uint32)
    primitive[(t == np.inf) | (random.random(t.shape) < 0.2)] = NONE
    a, b = (Seen(*one) for one in zip(t, primitive, strict=True))
    differing = 0
    for t_a, t_b, own, other in zip(*t.astype(np.float64), *primitive, strict=True):
        if np.isinf(t_a) or np.isinf(t_b):
            differing += t_a != t_b
        elif own != other or own == NONE:
            differing += abs(t_a - t_b) > SAME_DISTANCE * max(t_a, t_b)
    assert 0 < differing < 5000
    assert count_differences(a, b) == count_differences(b, a) == differing


@pytest.mark.parametrize("wanted", [1, 100, 4096])
def test_what_is_common_to_all_rays_and_some_of_them_is_these(wanted: int):
    count = 4096
    t = np.arange(count, dtype=np.float32)
    primitive = np.arange(count, dtype=np.uint32)
    everything = Sight(evenly(count, count), Seen(t, primitive))
    places = evenly(count, wanted)
    some = Sight(places, Seen(t[places], primitive[places]))
    # The last places are beyond those of a file that is shorter.
    fewer = Sight(np.arange(64), Seen(t[:64], primitive[:64]))
    for one, two in ((everything, some), (some, everything), (fewer, some), (some, fewer)):
        own, theirs = one.both(two)
        common = np.intersect1d(one.places, two.places)
        assert np.array_equal(own.primitive, common), (wanted, len(one.places), len(two.places))
        assert np.array_equal(theirs.primitive, common), (wanted, own.primitive[:5], common[:5])


def test_only_rays_that_both_have_traced_are_compared():
    one = Sight(np.array([0, 2, 4]), seen((1.0, 1), (1.0, 2), (1.0, 3)))
    two = Sight(np.array([2, 3, 4]), seen((1.0, 2), (9.0, 9), (3.0, 7)))
    share = compare(*one.both(two), any_hit=False)
    assert (share.count, share.rays) == (1, 2)
