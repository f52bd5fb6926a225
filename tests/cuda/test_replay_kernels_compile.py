"""The kernels that replay rays compile for every architecture, without a GPU and without spills."""

from types import ModuleType

import pytest

TRIANGLES, SPHERES, SMOOTH = 1, 2, 4


@pytest.mark.parametrize("architecture", [75, 80, 90, 100])
@pytest.mark.parametrize("any_hit", [False, True], ids=["closest", "any_hit"])
@pytest.mark.parametrize("features", [TRIANGLES, SPHERES, TRIANGLES | SPHERES])
def test_a_replay_kernel_spills_nothing(
    compiler: ModuleType, features: int, any_hit: bool, architecture: int
):
    result = compiler.compile_replay_kernel(
        any_hit, "watertight", features, architecture=architecture
    )
    kernel = result["kernels"]["haste_kernel"]
    assert kernel["spill_store_bytes"] == kernel["spill_load_bytes"] == 0, result["log"]
    # Four blocks of 256 threads live on a multiprocessor at a time.
    assert 4 * 256 * kernel["registers"] <= 65536, result["log"]
    warnings = [line for line in result["log"].splitlines() if not line.startswith("ptxas")]
    assert not warnings, "\n".join(warnings)


def test_what_a_scene_shades_with_makes_no_other_kernel(compiler: ModuleType):
    cubins = [
        compiler.compile_replay_kernel(False, "watertight", features, architecture=90)["cubin"]
        for features in (TRIANGLES, TRIANGLES | SMOOTH)
    ]
    assert cubins[0] == cubins[1]


def test_a_scene_without_primitives_has_no_replay_kernel(compiler: ModuleType):
    with pytest.raises(ValueError, match="needs triangles, spheres or both"):
        compiler.compile_replay_kernel(False, "watertight", SMOOTH, architecture=90)


def test_an_unknown_precision_has_no_replay_kernel(compiler: ModuleType):
    with pytest.raises(ValueError, match="no kernel for the precision 'sloppy'"):
        compiler.compile_replay_kernel(False, "sloppy", TRIANGLES, architecture=90)
