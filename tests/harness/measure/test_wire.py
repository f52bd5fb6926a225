"""Messages with arrays through a pipe: what arrives is what was sent, or an end is reported."""

from __future__ import annotations

from dataclasses import dataclass
from multiprocessing import Pipe
from threading import Thread

import numpy as np
import pytest
from numpy.typing import NDArray

from harness.measure.wire import receive, send


@dataclass(frozen=True, slots=True)
class Message:
    name: str
    arrays: tuple[NDArray[np.generic], ...]


def sent(message: object) -> object:
    """What arrives at the other end."""
    here, there = Pipe()
    thread = Thread(target=send, args=(here, message))
    thread.start()
    try:
        return receive(there)
    finally:
        thread.join()
        here.close()
        there.close()


ARRAYS = (
    np.arange(3_000_000, dtype=np.float32),
    np.zeros((0, 3), np.float32),
    np.array(2.5),
    np.arange(12, dtype=np.uint32).reshape(3, 4).T,
    np.arange(24, dtype=np.int64)[::2],
    np.array([np.nan, -0.0, np.inf], np.float32),
)


def test_arrays_of_any_size_and_order_arrive_bit_for_bit():
    answer = sent(Message("rays", ARRAYS))
    assert isinstance(answer, Message) and answer.name == "rays"
    for index, (own, other) in enumerate(zip(ARRAYS, answer.arrays, strict=True)):
        assert (own.dtype, own.shape) == (other.dtype, other.shape), index
        assert own.tobytes() == other.tobytes(), index


def test_what_arrives_may_be_written_to():
    answer = sent(ARRAYS[0])
    assert isinstance(answer, np.ndarray)
    answer += 1.0
    assert answer[0] == 1.0


def test_a_message_without_arrays_arrives():
    assert sent({"status": "ok", "rays": 5}) == {"status": "ok", "rays": 5}


def test_several_messages_are_kept_apart():
    here, there = Pipe()
    for number in range(3):
        send(here, (number, np.full(100, number)))
    for number in range(3):
        index, values = receive(there)
        assert index == number and (values == number).all(), (index, values[:5])


def test_an_end_within_an_array_is_an_end():
    here, there = Pipe()
    here.send((b"never read", [1000]))
    here.close()
    with pytest.raises(EOFError):
        receive(there)


def test_nobody_at_the_other_end_is_an_error_of_the_connection():
    here, there = Pipe()
    there.close()
    with pytest.raises(ConnectionError):
        send(here, ARRAYS[0])
