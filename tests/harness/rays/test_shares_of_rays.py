"""Arrays that are computed part by part: every row once, and no fault is lost in a thread."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from harness.rays.parts import PART, Parts, Rows


@pytest.mark.parametrize("count", [0, 1, PART - 1, PART, PART + 1, 3 * PART + 7])
@pytest.mark.parametrize("threads", [1, 3])
def test_every_row_is_made_once_and_rounded_to_the_type_of_its_array(count: int, threads: int):
    made = np.zeros(count, np.int64)

    def make(rows: Rows) -> tuple[np.ndarray, np.ndarray]:
        np.add.at(made, rows, 1)
        return rows / 3.0, np.stack([rows, -rows], axis=1)

    single, pairs = np.full(count, np.nan, np.float32), np.zeros((count, 2), np.int64)
    with ThreadPoolExecutor(threads) as pool:
        Parts(pool).fill(make, single, pairs)
    rows = np.arange(count)
    assert (made == 1).all(), np.flatnonzero(made != 1)[:5]
    assert np.array_equal(single, (rows / 3.0).astype(np.float32))
    assert np.array_equal(pairs, np.stack([rows, -rows], axis=1))


def test_what_is_raised_in_a_part_is_raised():
    def make(rows: Rows) -> tuple[np.ndarray]:
        if rows[0] > 0:
            raise ValueError(f"row {rows[0]}")
        return (rows,)

    with (
        ThreadPoolExecutor(2) as pool,
        pytest.raises(ValueError, match=f"row {PART}"),
    ):
        Parts(pool).fill(make, np.zeros(2 * PART, np.int64))
