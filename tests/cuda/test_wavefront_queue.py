"""The ring of `wavefront`, stepped through without a GPU."""

from __future__ import annotations

import random

import numpy as np
import pytest
from haste_cuda._core import testing

TREES = [(1, 1), (8, 1), (2, 3), (3, 2), (4, 3), (7, 2), (3, 9)]
"""(generations, children)."""


def expected(tree: tuple[int, int], samples: int, fertile: int) -> np.ndarray:
    """Every ray's node, sorted, from a queue that is larger than all of them, one packet each."""
    rays = samples * testing.most_rays(tree)
    order, _, _ = testing.drain_wavefront_queue(tree, 2 * rays + 8, rays, samples, fertile)
    return np.sort(order)


@pytest.mark.parametrize("fertile", [100, 60])
@pytest.mark.parametrize("tree", TREES, ids=str)
def test_every_ray_is_traced_once_whatever_the_room_and_the_packet(
    tree: tuple[int, int], fertile: int
):
    draw = random.Random(f"{tree} {fertile}")
    need = testing.lifo_need(*tree)
    for _ in range(40):
        capacity = need + int(draw.expovariate(0.2 / need))
        packet = min(1 + int(draw.expovariate(2 / capacity)), capacity)
        samples = draw.randrange(1, 40)
        order, peak, _ = testing.drain_wavefront_queue(tree, capacity, packet, samples, fertile)
        told = f"{samples} samples of {tree} in packets of {packet} and room for {capacity}"
        assert np.array_equal(np.sort(order), expected(tree, samples, fertile)), told
        assert peak <= capacity + packet, told


@pytest.mark.parametrize("tree", TREES, ids=str)
def test_nothing_is_copied_where_there_is_room(tree: tuple[int, int]):
    """Room for all that two packets spawn, and more samples than one packet holds."""
    _, children = tree
    packet = 64
    capacity = 4 * packet * max(2, children) * testing.lifo_need(*tree)
    _, _, moved = testing.drain_wavefront_queue(tree, capacity, packet, 300, 100)
    assert moved == 0, f"{moved} rays in a queue for {capacity}"


def test_gaps_are_closed_where_room_is_short():
    """Without this the tests above would say nothing of the newest rays."""
    tree = (4, 3)
    _, _, moved = testing.drain_wavefront_queue(tree, testing.lifo_need(*tree) + 12, 4, 40, 100)
    assert moved > 0, f"no ray was copied in room for {testing.lifo_need(*tree) + 12}"
