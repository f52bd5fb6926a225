"""The bounded queue never overflows and always runs dry, whatever rays spawn."""

from __future__ import annotations

import random

import numpy as np
import pytest
from haste_cuda._core import testing

TREES = [(1, 1), (8, 1), (2, 3), (5, 2), (6, 3), (17, 2), (17, 6)]
"""(generations, children): `path`, one layer with ambient rays, and up to 16 layers."""


def drain(
    tree: tuple[int, int], capacity: int, packet: int, unborn: int, lifo: bool, spawn: random.Random
) -> int:
    """Run a queue of rays, each known by its generation alone; return its peak."""
    generations, children = tree
    queue: list[int] = []
    peak = steps = 0
    # Deep trees stay small enough to walk, but single rays spawn all that they can.
    fertile = spawn.uniform(0.0, 1.2 / children)
    while queue or unborn:
        pending, born, newest = testing.next_packet(tree, capacity, packet, len(queue), unborn)
        assert 0 < pending + born <= packet, "a packet is empty or too large"
        assert pending <= len(queue) and born <= unborn
        if lifo or newest:
            queue, taken = queue[: len(queue) - pending], queue[len(queue) - pending :]
        else:
            queue, taken = queue[pending:], queue[:pending]
        unborn -= born
        spawned = [
            generation + 1
            for generation in [*taken, *[1] * born]
            if generation < generations and spawn.random() <= fertile
            for _ in range(children)
        ]
        spawn.shuffle(spawned)
        queue += spawned
        peak = max(peak, len(queue))
        assert peak <= capacity, f"{peak} rays in room for {capacity}"
        steps += 1
        assert steps < 100_000, "no end"
    return peak


@pytest.mark.parametrize("tree", TREES, ids=str)
@pytest.mark.parametrize("lifo", [False, True], ids=["fifo", "lifo"])
def test_a_queue_at_any_limit_ends_and_stays_below_it(tree: tuple[int, int], lifo: bool) -> None:
    spawn = random.Random(f"{tree} {lifo}")
    need = testing.lifo_need(*tree)
    for _ in range(40):
        capacity = need + int(spawn.expovariate(0.3 / need))
        packet = min(1 + int(spawn.expovariate(2 / capacity)), capacity)
        samples = spawn.randrange(1, 60)
        peak = drain(tree, capacity, packet, samples, lifo, spawn)
        told = f"{samples} samples of {tree} in packets of {packet}"
        assert 0 <= peak <= capacity, f"{told}: {peak} rays in room for {capacity}"


@pytest.mark.parametrize("tree", [(3, 2), (4, 3), (6, 2)], ids=str)
def test_a_full_tree_ends_with_room_for_one_walk_alone(tree: tuple[int, int]) -> None:
    """The tightest queue that is accepted, and every ray has all the children it can."""

    class Greedy(random.Random):
        def random(self) -> float:
            return 0.0

    need = testing.lifo_need(*tree)
    assert drain(tree, need, need, 9, False, Greedy(1)) <= need


def test_the_need_is_that_of_a_depth_first_walk() -> None:
    """Every generation but the first leaves all children but one behind."""
    assert testing.lifo_need(8, 1) == 1
    assert testing.lifo_need(16, 2) == 16
    assert testing.lifo_need(17, 3) == 33


def test_a_roomy_queue_gives_whole_packets_in_its_own_order() -> None:
    assert testing.next_packet((5, 2), 1 << 20, 256, 1000, 1000) == (256, 0, False)
    assert testing.next_packet((5, 2), 1 << 20, 256, 100, 1000) == (100, 156, False)
    assert testing.next_packet((5, 2), 1 << 20, 256, 0, 10) == (0, 10, False)


def test_a_queue_near_its_limit_admits_no_sample_and_takes_the_newest_rays() -> None:
    pending, born, newest = testing.next_packet((5, 2), 100, 64, 99, 1000)
    assert pending > 0 and born == 0 and newest


@pytest.mark.parametrize("tree", TREES, ids=str)
def test_a_samples_rays_are_those_of_all_its_generations(tree: tuple[int, int]) -> None:
    generations, children = tree
    rays = sum(children**generation for generation in range(generations))
    assert testing.most_rays(tree) == rays, f"{generations} generations of {children} children"


@pytest.mark.parametrize("tree", [(63, 2), (64, 2), (65535, 65535), (2, 2**32 - 1)], ids=str)
def test_more_rays_than_a_number_holds_are_the_most(tree: tuple[int, int]) -> None:
    generations, children = tree
    rays = sum(children**generation for generation in range(min(generations, 70)))
    assert testing.most_rays(tree) == min(rays, 2**62), f"{generations} of {children}"


SAMPLES = (8, 4, 40)
"""Width, height, samples a pixel."""


@pytest.mark.parametrize("lifo", [False, True], ids=["fifo", "lifo"])
@pytest.mark.parametrize("limit", [None, 0.5], ids=["roomy", "throttled"])
def test_every_ray_leaves_the_queue_once_and_room_made_beforehand_changes_nothing(
    lifo: bool, limit: float | None
) -> None:
    """64 kB a thousand rays: some of these queues begin with a page of 2 MiB, others grow to it."""
    tree, packet = (4, 3), 700
    width, height, spp = SAMPLES
    rays = width * height * spp * testing.most_rays(tree)
    queue_bytes = int((limit or 100) * packet * 3 * testing.ray_bytes)
    drained = [
        testing.drain_ray_queue(tree, SAMPLES, packet, queue_bytes, lifo, reserved)
        for reserved in (0, 1, 5000, 1 << 20)
    ]
    order, peak = drained[0]
    assert len(order) == len(np.unique(order, axis=0)) == rays
    assert 0 < peak <= queue_bytes
    for other, other_peak in drained[1:]:
        assert np.array_equal(other, order) and other_peak == peak, "room made beforehand is seen"
