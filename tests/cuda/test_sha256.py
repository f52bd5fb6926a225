"""SHA-256 against Python's own."""

import hashlib
import random
from types import ModuleType

import pytest


@pytest.mark.parametrize(
    "size", [0, 1, 3, 55, 56, 57, 63, 64, 65, 119, 120, 127, 128, 1000, 99_991]
)
def test_sha256_equals_hashlib_at_every_padding_boundary(core: ModuleType, size: int):
    data = random.Random(size).randbytes(size)
    assert core.sha256(data) == hashlib.sha256(data).hexdigest(), f"{size} bytes"


def test_sha256_changes_with_one_bit(core: ModuleType):
    data = bytearray(100)
    before = core.sha256(bytes(data))
    data[50] ^= 1
    assert core.sha256(bytes(data)) != before
