"""The cache of compiled kernels: what hits, what misses, and what a damaged file does."""

import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from haste_cuda import nvrtc

SOURCE = 'extern "C" __global__ void k(float* p) { p[0] = 1; }\n'

RACER = """
import sys, time
from haste_cuda import _core, nvrtc
nvrtc.configure()
_core.nvrtc_version()
while time.time() < float(sys.argv[1]):
    pass
print(_core.sha256(_core.compile_source(sys.argv[2], 90)["cubin"]))
"""


def without_times(result: dict[str, object]) -> dict[str, object]:
    return {key: value for key, value in result.items() if key not in ("seconds", "cached")}


def test_the_second_compilation_is_a_load(compiler: ModuleType, cache: Path):
    first = compiler.compile_source(SOURCE, 90)
    loads = [compiler.compile_source(SOURCE, 90) for _ in range(5)]
    assert not first["cached"]
    assert all(load["cached"] for load in loads)
    assert without_times(first) == without_times(loads[0])
    assert [path.suffix for path in cache.iterdir()] == [".cubin"]


@pytest.mark.usefixtures("cache")
def test_whatever_decides_the_result_is_part_of_the_key(
    compiler: ModuleType, tmp_path: Path, request: pytest.FixtureRequest
):
    request.addfinalizer(lambda: compiler.set_include_root(str(Path(nvrtc.__file__).parent)))
    root = tmp_path / "root"
    (root / "core").mkdir(parents=True)
    header = root / "core" / "one.h"
    header.write_text("constexpr int one = 1;\n")
    compiler.set_include_root(str(root))
    keys = {"plain": compiler.cubin_cache_file(SOURCE, 90)}
    keys["source"] = compiler.cubin_cache_file(SOURCE + "\n", 90)
    keys["architecture"] = compiler.cubin_cache_file(SOURCE, 80)
    keys["options"] = compiler.cubin_cache_file(SOURCE, 90, ["--fmad=false"])
    keys["name"] = compiler.cubin_cache_file(SOURCE, 90, [], "other.cu")
    header.write_text("constexpr int one = 2;\n")
    keys["header's contents"] = compiler.cubin_cache_file(SOURCE, 90)
    header.rename(root / "core" / "two.h")
    keys["header's name"] = compiler.cubin_cache_file(SOURCE, 90)
    (root / "core" / "kernel.cuh").touch()
    keys["another header"] = compiler.cubin_cache_file(SOURCE, 90)
    assert len(set(keys.values())) == len(keys), keys


@pytest.mark.usefixtures("cache")
def test_the_folder_of_the_headers_is_no_part_of_the_key(
    compiler: ModuleType, tmp_path: Path, request: pytest.FixtureRequest
):
    request.addfinalizer(lambda: compiler.set_include_root(str(Path(nvrtc.__file__).parent)))
    files = []
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "one.h").write_text("constexpr int one = 1;\n")
        compiler.set_include_root(str(tmp_path / name))
        files.append(compiler.cubin_cache_file(SOURCE, 90))
    assert files[0] == files[1]


@pytest.mark.parametrize("damage", ["empty", "truncated", "one bit", "another format", "trailing"])
def test_a_damaged_file_counts_as_absent_and_is_replaced(
    compiler: ModuleType, cache: Path, damage: str
):
    first = compiler.compile_source(SOURCE, 90)
    file = Path(compiler.cubin_cache_file(SOURCE, 90))
    assert file.parent == cache
    sound = file.read_bytes()
    middle = len(sound) // 2
    file.write_bytes(
        {
            "empty": b"",
            "truncated": sound[:middle],
            "one bit": sound[:middle] + bytes([sound[middle] ^ 1]) + sound[middle + 1 :],
            "another format": b"\xff" * len(sound),
            "trailing": sound + b"\0",
        }[damage]
    )
    again = compiler.compile_source(SOURCE, 90)
    assert not again["cached"]
    assert again["cubin"] == first["cubin"]
    assert compiler.compile_source(SOURCE, 90)["cached"]


def test_processes_that_race_all_get_the_program_and_leave_one_file(
    compiler: ModuleType, cache: Path
):
    start = str(time.time() + 2)
    command = [sys.executable, "-c", RACER, start, SOURCE]
    racers = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(4)]
    outputs = [racer.communicate()[0].strip() for racer in racers]
    assert [racer.returncode for racer in racers] == [0] * len(racers)
    assert outputs == [compiler.sha256(compiler.compile_source(SOURCE, 90)["cubin"])] * 4
    assert [path.suffix for path in cache.iterdir()] == [".cubin"]


def test_a_cache_that_cannot_be_written_is_told_and_costs_nothing_else(
    compiler: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    blocked = tmp_path / "file"
    blocked.touch()
    monkeypatch.setenv("HASTE_CACHE", str(blocked))
    result = compiler.compile_source(SOURCE, 90)
    assert result["cubin"].startswith(b"\x7fELF")
    assert not result["cached"]
    assert str(blocked) in result["cache_problem"], result["cache_problem"]


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({"HASTE_CACHE": "/a", "XDG_CACHE_HOME": "/b", "HOME": "/c"}, "/a/cubin"),
        ({"XDG_CACHE_HOME": "/b", "HOME": "/c"}, "/b/haste/cubin"),
        ({"HASTE_CACHE": "", "XDG_CACHE_HOME": "", "HOME": "/c"}, "/c/.cache/haste/cubin"),
    ],
)
def test_the_cache_lies_where_the_environment_says(
    core: ModuleType, monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], expected: str
):
    for name in ("HASTE_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert core.cubin_cache_directory() == expected
