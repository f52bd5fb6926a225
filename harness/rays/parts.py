"""Arrays of millions of rows, computed part by part on several threads.

What a part needs stays in a processor's cache, and NumPy lets go of the interpreter's lock while it
computes. What comes of a row depends on neither parts nor threads.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

PART = 1 << 15
"""Rows that are computed together."""

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Parts:
    """Threads that share rows out among them."""

    pool: ThreadPoolExecutor

    def fill(
        self, make: Callable[[Rows], tuple[NDArray[Any], ...]], *results: NDArray[Any]
    ) -> None:
        """Fill all rows of arrays of one length.

        Parameters
        ----------
        make
            Takes the numbers of some rows, and gives these rows of every array.
        results
            The arrays, whose types what is made is rounded to.
        """
        count = len(results[0])

        def one(start: int) -> None:
            rows = np.arange(start, min(start + PART, count))
            for result, values in zip(results, make(rows), strict=True):
                result[rows[0] : rows[-1] + 1] = values

        # A list, so that what is raised in a thread is raised here.
        list(self.pool.map(one, range(0, count, PART)))
