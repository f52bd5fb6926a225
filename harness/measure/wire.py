"""Messages through a pipe, whose arrays go from memory to memory and through no pickle.

Hits of millions of rays would be copied five times on their way through a connection's own `send`
and `recv`.
"""

import os
import pickle
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]


def send(connection: Connection, message: object) -> None:
    """Send a message that `receive` takes: its pickle, and after that its arrays as they are.

    Raises
    ------
    ConnectionError
        Nobody is there to take it.
    """
    arrays: list[pickle.PickleBuffer] = []
    text = pickle.dumps(message, protocol=5, buffer_callback=arrays.append)
    parts = [array.raw() for array in arrays]
    connection.send((text, [part.nbytes for part in parts]))
    for part in parts:
        _write(connection.fileno(), part)


def receive(connection: Connection) -> Any:
    """Wait for a message of `send`.

    Raises
    ------
    EOFError, ConnectionError
        The other end is gone.
    """
    text, sizes = connection.recv()
    arrays = [_read(connection.fileno(), size) for size in sizes]
    return pickle.loads(text, buffers=arrays)  # noqa: S301 - from a process of our own


def _write(descriptor: int, part: memoryview) -> None:
    while part.nbytes:
        part = part[os.write(descriptor, part) :]


def _read(descriptor: int, size: int) -> Bytes:
    part = np.empty(size, np.uint8)
    done = 0
    while done < size:
        got = os.readv(descriptor, [part[done:]])
        if not got:
            raise EOFError
        done += got
    return part
