"""Which NVRTC is taken: the newest that the driver can follow; else a reason that helps."""

from pathlib import Path

import pytest
from stubs import build_library, run_python, stub_driver, stub_nvrtc

from haste_cuda import nvrtc

CHOOSE = """
from haste_cuda import _core, nvrtc
nvrtc.wheel_folders = lambda major: [nvrtc.Path({folder!r})]
nvrtc.toolkit_folders = lambda major: []
_core.set_nvrtc_candidates(nvrtc.nvrtc_candidates())
print(_core.nvrtc_unavailable() or _core.nvrtc_path() + " " + str(_core.nvrtc_version()))
"""


def choose(tmp_path: Path, *, driver: int | None, compilers: list[int]) -> str:
    """What a process says that has this driver and these compilers."""
    if driver is not None:
        build_library(tmp_path / "driver" / "libcuda.so.1", stub_driver(driver))
    for major in compilers:
        build_library(tmp_path / "wheel" / f"libnvrtc.so.{major}", stub_nvrtc(major, 9))
    program = CHOOSE.format(folder=str(tmp_path / "wheel"))
    return run_python(program, tmp_path / "driver" if driver is not None else None)


@pytest.mark.parametrize(
    ("driver", "compilers", "expected"),
    [
        (None, [12, 13], 13),
        (13000, [12, 13], 13),
        (14010, [12, 13], 13),
        (12040, [12, 13], 12),
        (13000, [12], 12),
    ],
)
def test_the_newest_compiler_that_the_driver_can_follow_is_taken(
    tmp_path: Path, driver: int | None, compilers: list[int], expected: int
):
    library = tmp_path / "wheel" / f"libnvrtc.so.{expected}"
    output = choose(tmp_path, driver=driver, compilers=compilers)
    assert output == f"{library} {1000 * expected + 90}"


def test_a_driver_is_given_no_newer_compiler_but_the_name_of_the_wheel(tmp_path: Path):
    output = choose(tmp_path, driver=12040, compilers=[13])
    assert "pip install nvidia-cuda-nvrtc-cu12;" in output, output
    assert "libnvrtc.so.13 is too new for a driver of CUDA 12.4" in output, output


def test_without_any_compiler_the_wheel_is_named_and_what_was_tried(tmp_path: Path):
    output = choose(tmp_path, driver=None, compilers=[])
    assert "pip install nvidia-cuda-nvrtc;" in output, output
    assert "libnvrtc.so.13: cannot open shared object file" in output, output


def test_a_damaged_library_is_passed_over(tmp_path: Path):
    (tmp_path / "wheel").mkdir()
    (tmp_path / "wheel" / "libnvrtc.so.13").write_bytes(b"no library")
    output = choose(tmp_path, driver=None, compilers=[12])
    assert output.startswith(str(tmp_path / "wheel" / "libnvrtc.so.12")), output


def test_wheels_come_before_toolkits_and_those_before_the_linkers_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    for folder in ("wheel", "toolkit/lib64"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "libnvrtc.so.13").touch()
    monkeypatch.setattr(nvrtc, "wheel_folders", lambda _major: [tmp_path / "wheel"])
    monkeypatch.delenv("CUDA_PATH", raising=False)
    monkeypatch.setenv("CUDA_HOME", str(tmp_path / "toolkit"))
    found = [path for major, path in nvrtc.nvrtc_candidates() if major == 13]
    assert found[:2] == [
        str(tmp_path / "wheel" / "libnvrtc.so.13"),
        str(tmp_path / "toolkit" / "lib64" / "libnvrtc.so.13"),
    ]
    assert found[-1] == "libnvrtc.so.13"


def test_a_later_change_of_mind_is_refused():
    output = run_python(
        "from haste_cuda import _core, nvrtc\n"
        "nvrtc.configure(); _core.nvrtc_unavailable(); nvrtc.configure()\n"
        "try:\n    _core.set_nvrtc_candidates([])\nexcept RuntimeError as error:\n    print(error)"
    )
    assert "already in use" in output, output
