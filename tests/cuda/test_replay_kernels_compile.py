"""The kernels that replay rays compile for every architecture, without a GPU and without spills."""

from types import ModuleType

import pytest
from faults import faults

from haste_cuda import _core

TRIANGLES, SPHERES, SMOOTH = 1, 2, 4


TRAVERSALS = ("brute_force", "bvh2", "bvh2_stackless", "bvh8")


def test_every_traversal_is_compiled_here():
    assert tuple(_core.traversals()) == TRAVERSALS


@pytest.mark.parametrize("architecture", [75, 80, 90, 100])
@pytest.mark.parametrize("any_hit", [False, True], ids=["closest", "any_hit"])
@pytest.mark.parametrize("features", [TRIANGLES, SPHERES, TRIANGLES | SPHERES])
@pytest.mark.parametrize("traversal", TRAVERSALS)
def test_a_replay_kernel_spills_nothing(
    compiler: ModuleType, traversal: str, features: int, any_hit: bool, architecture: int
):
    # Resident rays of both kinds keep what either test needs; sm_90 is what they are tuned for.
    fewer = traversal == "bvh8" and (features == TRIANGLES | SPHERES or architecture != 90)
    result = compiler.compile_replay_kernel(
        any_hit, "watertight", features, traversal, architecture=architecture
    )
    found = faults(result, blocks=3 if fewer else 4)
    assert not found, f"{traversal}, features {features}: {found}\n{result['log']}"


@pytest.mark.parametrize("traversal", TRAVERSALS)
def test_a_replay_kernel_of_fast_arithmetic_spills_nothing(compiler: ModuleType, traversal: str):
    result = compiler.compile_replay_kernel(False, "fast", TRIANGLES, traversal, architecture=90)
    found = faults(result, blocks=4)
    assert not found, f"{traversal}: {found}\n{result['log']}"


@pytest.mark.parametrize("any_hit", [False, True], ids=["closest", "any_hit"])
@pytest.mark.parametrize("traversal", TRAVERSALS)
def test_a_replay_kernel_that_counts_spills_nothing(
    compiler: ModuleType, traversal: str, any_hit: bool
):
    result = compiler.compile_replay_kernel(
        any_hit, "watertight", TRIANGLES | SPHERES, traversal, count=True, architecture=90
    )
    found = faults(result, blocks=4)
    assert not found, f"{traversal}, any hit {any_hit}: {found}\n{result['log']}"


def test_what_a_scene_shades_with_makes_no_other_kernel(compiler: ModuleType):
    cubins = [
        compiler.compile_replay_kernel(False, "watertight", features, architecture=90)["cubin"]
        for features in (TRIANGLES, TRIANGLES | SMOOTH)
    ]
    assert cubins[0] == cubins[1]


def test_a_scene_without_primitives_has_no_replay_kernel(compiler: ModuleType):
    with pytest.raises(ValueError, match="needs triangles, spheres or both"):
        compiler.compile_replay_kernel(False, "watertight", SMOOTH, architecture=90)


def test_an_unknown_traversal_has_no_replay_kernel(compiler: ModuleType):
    with pytest.raises(ValueError, match="no traversal 'kd_tree'; it has brute_force, bvh2, "):
        compiler.compile_replay_kernel(False, "watertight", TRIANGLES, "kd_tree", architecture=90)


def test_an_unknown_precision_has_no_replay_kernel(compiler: ModuleType):
    with pytest.raises(ValueError, match="no kernel for the precision 'sloppy'"):
        compiler.compile_replay_kernel(False, "sloppy", TRIANGLES, architecture=90)
