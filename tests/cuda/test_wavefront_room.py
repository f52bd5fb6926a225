"""How `wavefront` shares the bytes of its queue out among streams; no GPU is needed."""

from __future__ import annotations

import random
from typing import NamedTuple

import pytest
from haste_cuda._core import testing

RAY_BYTES, HIT_BYTES, SHADOW_BYTES = 64, 16, 52


class Ask(NamedTuple):
    """What a schedule and a scene ask for."""

    tree: tuple[int, int]
    """generations and children of a sample's rays"""
    bytes: int
    packet: int
    lanes: int
    most_shadow_rays: int


class Room(NamedTuple):
    """What they are given."""

    lanes: int
    packet: int
    queue: int


def fit(ask: Ask) -> Room:
    return Room(*testing.wavefront_room(*ask))


def packet_ray_bytes(shadows: int) -> int:
    """A ray of a packet with its hit and its shadow rays."""
    return RAY_BYTES + HIT_BYTES + SHADOW_BYTES * shadows


def least_bytes(tree: tuple[int, int], shadows: int) -> int:
    """The rays of one sample that can wait, and a packet of one ray."""
    return RAY_BYTES * testing.lifo_need(*tree) + packet_ray_bytes(shadows)


def asks(count: int) -> list[Ask]:
    """From what is just enough to more than can be used."""
    choose = random.Random(1)
    found = []
    for _ in range(count):
        tree = (choose.randrange(1, 18), choose.randrange(1, 9))
        shadows = choose.choice([0, 1, 4, 32])
        size = least_bytes(tree, shadows) + int(2 ** choose.uniform(0, 38))
        packet = int(2 ** choose.uniform(0, 26))
        found.append(Ask(tree, size, packet, choose.randrange(1, 9), shadows))
    return found


ASKS = asks(2000)


def test_all_lanes_stay_within_the_bytes():
    for ask in ASKS:
        room = fit(ask)
        own = room.packet * packet_ray_bytes(ask.most_shadow_rays) + RAY_BYTES * room.queue
        assert room.lanes * own <= ask.bytes, f"{ask} gave {room}"


def test_every_lane_holds_what_one_sample_needs_and_a_packet():
    for ask in ASKS:
        room = fit(ask)
        assert room.queue >= testing.lifo_need(*ask.tree), f"{ask} gave {room}"
        assert 1 <= room.packet <= ask.packet, f"{ask} gave {room}"


def test_a_lane_more_makes_no_packet_smaller():
    for ask in ASKS:
        alone, room = fit(ask._replace(lanes=1)), fit(ask)
        assert room.packet == alone.packet, f"{ask} gave {room}, one lane {alone}"
        assert 1 <= room.lanes <= ask.lanes, f"{ask} gave {room}"


def test_there_are_as_many_lanes_as_room_for_them():
    for ask in ASKS:
        room = fit(ask)
        if room.lanes == ask.lanes:
            continue
        # One lane more would have had to cut its packets, or had no room at all.
        own = ask.bytes // (room.lanes + 1)
        if own >= least_bytes(ask.tree, ask.most_shadow_rays):
            cut = fit(ask._replace(bytes=own, lanes=1))
            assert cut.packet < room.packet, f"{ask} gave {room}, though {own} bytes give {cut}"


def test_the_usual_settings_have_three_lanes_with_packets_of_their_size():
    usual = Ask((6, 6), 4 << 30, 1 << 20, 3, 4)
    assert fit(usual)[:2] == (3, 1 << 20)


def test_too_few_bytes_are_refused_and_one_more_is_enough():
    tree, shadows = (6, 6), 4
    least = least_bytes(tree, shadows)
    with pytest.raises(ValueError, match=f"queue_bytes must be at least {least}"):
        fit(Ask(tree, least - 1, 64, 3, shadows))
    assert fit(Ask(tree, least, 64, 3, shadows))[:2] == (1, 1)
