"""Elementary functions of the core: near the exact values, equal bits on all platforms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from haste_cuda._core import testing
from numpy.typing import NDArray

COUNT = 1_000_000
Function = Callable[[NDArray[np.longdouble]], NDArray[np.longdouble]]


def arguments(name: str) -> NDArray[np.float32]:
    """Where the models call a function: over all magnitudes, ends included."""
    random = np.random.default_rng(17)
    size = 10.0 ** random.uniform(-12, 0, COUNT)
    if name in {"exp", "expm1"}:
        return np.append(-size * random.choice([1.0, 10.0, 80.0], COUNT), [0.0, -0.0]).astype("f4")
    if name == "log1p":
        near = np.where(random.random(COUNT) < 0.5, size, random.random(COUNT))
        return np.append(-near * (1.0 - 2.0**-24), [0.0, 2.0**-24 - 1.0]).astype("f4")
    return np.append(random.random(COUNT) * size, [0.0, 2.0**-24]).astype("f4")


@pytest.mark.parametrize(
    ("name", "exact"),
    [("exp", np.exp), ("expm1", np.expm1), ("log1p", np.log1p), ("cbrt", np.cbrt)],
)
def test_values_are_within_two_ulp_in_both_precisions(name: str, exact: Function) -> None:
    x = arguments(name)
    truth = exact(x.astype(np.longdouble))
    for values in testing.elementary(name, x):
        one = np.spacing(np.abs(truth).astype(values.dtype)).astype(np.longdouble)
        off = np.abs(values.astype(np.longdouble) - truth) / one
        worst = int(np.argmax(off))
        assert off[worst] <= 2.0, f"{name}({x[worst]!r}) is off by {off[worst]:.3g} ulp"


def test_values_at_the_ends_are_what_the_models_count_on() -> None:
    def value(name: str, x: float) -> float:
        return float(testing.elementary(name, np.array([x], np.float32))[0][0])

    assert value("exp", 0.0) == 1.0 and value("exp", -1e30) == 0.0
    assert value("exp", -np.inf) == 0.0 and value("exp", 1e30) == np.inf
    assert value("expm1", 0.0) == 0.0 and value("expm1", -np.inf) == -1.0
    assert value("log1p", 0.0) == 0.0 and value("log1p", -1.0) == -np.inf
    assert value("cbrt", 0.0) == 0.0 and value("cbrt", 1.0) == 1.0
