"""Agreement between tracers: what counts as a difference, and which rays are compared."""

from itertools import pairwise

import numpy as np
import pytest

from harness.eye_rays import Seen
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


def test_only_rays_that_both_have_traced_are_compared():
    one = Sight(np.array([0, 2, 4]), seen((1.0, 1), (1.0, 2), (1.0, 3)))
    two = Sight(np.array([2, 3, 4]), seen((1.0, 2), (9.0, 9), (3.0, 7)))
    share = compare(*one.both(two), any_hit=False)
    assert (share.count, share.rays) == (1, 2)
