"""Every kernel of every engine compiles in every model, without a GPU and without spills."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import pytest
from faults import faults

from haste_cuda import _core

BITS = len(_core.feature_names())
ALL_FEATURES = (1 << BITS) - 1
TRIANGLES, SPHERES, MESH_LIGHTS, AMBIENT, DIFFUSE = 0, 1, 3, 10, 13
LEAST = 1 << TRIANGLES | 1 << MESH_LIGHTS | 1 << AMBIENT | 1 << DIFFUSE
STACK = 16
WITH_A_STACK = ("depth_first", "persistent")
WORKERS = 2


@dataclass(frozen=True)
class Program:
    """A kernel with all that it is compiled for."""

    kernel: str
    model: str
    features: int
    precision: str = "watertight"
    architecture: int = 90
    film: str = "int64"
    count_rays: bool = False
    layered: bool = False
    traversal: str = "bvh8"

    def compile(self, core: ModuleType) -> dict[str, Any]:
        stack = STACK if self.kernel in WITH_A_STACK and self.model != "path" else 1
        return core.compile_kernel(
            *(self.kernel, self.model, self.precision, self.features, stack),
            *(self.film, self.layered, self.count_rays, self.traversal),
            architecture=self.architecture,
            use_cache=False,
        )


KERNELS = _core.kernel_names()
MODELS = _core.kernel_models()
EVERY = [
    Program(kernel, model, features)
    for kernel in KERNELS
    for model in MODELS
    for features in (LEAST, ALL_FEATURES)
    # Full depth-first kernels are those of test_kernels_compile.py.
    if kernel != "depth_first" or features == LEAST
]

AXES: dict[str, list[Any]] = {
    "kernel": KERNELS,
    "model": MODELS,
    "precision": _core.kernel_precisions(),
    "architecture": [75, 80, 90, 100],
    "film": _core.kernel_films(),
    "count_rays": [False, True],
    "traversal": _core.traversals(),
    **{f"feature {bit}": [False, True] for bit in range(BITS)},
}


def pairs_of(row: dict[str, Any]) -> set[tuple[Any, ...]]:
    """All pairs of values that a program has at once."""
    return set(itertools.combinations(row.items(), 2))


def pairwise_cover() -> list[dict[str, Any]]:
    """A few programs in which any two values of any two axes meet, chosen greedily, seeded."""
    choose = random.Random(1)
    missing = {
        ((a, x), (b, y))
        for a, b in itertools.combinations(AXES, 2)
        for x in AXES[a]
        for y in AXES[b]
        # A scene has a primitive and a light.
        if not ({a, b} == {f"feature {TRIANGLES}", f"feature {SPHERES}"} and not (x or y))
    }
    rows = []
    while missing:
        seed = min(missing, key=repr)
        candidates = []
        for _ in range(60):
            row = {axis: choose.choice(values) for axis, values in AXES.items()} | dict(seed)
            if not (row[f"feature {TRIANGLES}"] or row[f"feature {SPHERES}"]):
                free = [bit for bit in (TRIANGLES, SPHERES) if f"feature {bit}" not in dict(seed)]
                row[f"feature {free[0]}"] = True
            candidates.append(row)
        best = max(candidates, key=lambda row: len(pairs_of(row) & missing))
        missing -= pairs_of(best)
        rows.append(best)
    return rows


def program_of(row: dict[str, Any]) -> Program:
    features = sum(1 << bit for bit in range(BITS) if row[f"feature {bit}"])
    fixed = {axis: value for axis, value in row.items() if not axis.startswith("feature")}
    return Program(features=features, **fixed)


COVER = [program_of(row) for row in pairwise_cover()]
LAYERED = [Program("packet", model, ALL_FEATURES, layered=True) for model in ("haste", "whitted")]


@pytest.fixture(scope="module")
def compiled(core: ModuleType) -> Iterator[dict[Program, Future[dict[str, Any]]]]:
    """The compilations, all under way from the start."""
    reason = core.nvrtc_unavailable()
    if reason is not None:
        pytest.skip(reason)
    with ThreadPoolExecutor(WORKERS) as pool:
        programs = dict.fromkeys(EVERY + COVER + LAYERED)
        yield {program: pool.submit(program.compile, core) for program in programs}
        pool.shutdown(cancel_futures=True)


@pytest.mark.parametrize("program", EVERY, ids=str)
def test_least_and_all_features_spill_nothing(
    compiled: dict[Program, Future[dict[str, Any]]], program: Program
):
    result = compiled[program].result()
    assert not faults(result), f"{program}: {faults(result)}\n{result['log']}"


@pytest.mark.parametrize("program", LAYERED, ids=str)
def test_a_film_a_layer_spills_nothing(
    compiled: dict[Program, Future[dict[str, Any]]], program: Program
):
    result = compiled[program].result()
    assert not faults(result), f"{program}: {faults(result)}\n{result['log']}"


@pytest.mark.parametrize("program", COVER, ids=str)
def test_any_two_of_what_a_program_can_have_go_together(
    compiled: dict[Program, Future[dict[str, Any]]], program: Program
):
    result = compiled[program].result()
    assert not faults(result), f"{program}: {faults(result)}\n{result['log']}"


def test_the_cover_is_small_and_complete():
    assert len(COVER) <= 60, f"{len(COVER)} programs"
    met = set().union(*map(pairs_of, pairwise_cover()))
    for a, b in itertools.combinations(AXES, 2):
        for x, y in itertools.product(AXES[a], AXES[b]):
            if {a, b} == {f"feature {TRIANGLES}", f"feature {SPHERES}"} and not (x or y):
                continue
            assert ((a, x), (b, y)) in met, f"{a} {x} never meets {b} {y}"
