"""A machine without CUDA gets a reason; one with CUDA gets its device."""

import re
from pathlib import Path
from types import ModuleType

import pytest
from stubs import build_library, run_python, stub_driver

REASON = "from haste_cuda import _core; print(_core.cuda_unavailable())"


def test_missing_cuda_is_a_reason_and_never_a_crash(core: ModuleType):
    reason = core.cuda_unavailable()
    if reason is None:
        assert core.device_info()["compute_capability"] >= (7, 5)
    else:
        assert len(reason) > 20, reason
        assert "\n" not in reason, reason


def test_a_device_query_without_a_driver_raises_the_reason(core: ModuleType):
    reason = core.driver_unavailable()
    if reason is None:
        pytest.skip("this machine has a CUDA driver and a device")
    with pytest.raises(core.CudaError) as raised:
        core.device_info()
    assert reason in str(raised.value)


def test_a_library_that_is_no_driver_gives_a_reason(tmp_path: Path):
    build_library(tmp_path / "libcuda.so.1", "int haste_no_driver;\n")
    assert "too old: it has no cu" in run_python(REASON, tmp_path)


@pytest.mark.parametrize(
    ("version", "devices", "init", "expected"),
    [
        (11080, 1, 0, "supports CUDA 11.8; 12.0 or newer is needed"),
        (13000, 0, 0, "sees no device"),
        (13000, 1, 100, "does not start: CUDA_ERROR_STUB, the stub's text"),
    ],
)
def test_a_driver_that_cannot_serve_says_why(
    tmp_path: Path, version: int, devices: int, init: int, expected: str
):
    build_library(tmp_path / "libcuda.so.1", stub_driver(version, devices, init))
    assert expected in run_python(REASON, tmp_path)


def test_a_driver_without_reason_against_it_is_available(tmp_path: Path):
    build_library(tmp_path / "libcuda.so.1", stub_driver(13000))
    program = (
        "from haste_cuda import _core; print(_core.driver_unavailable(), _core.driver_version())"
    )
    assert run_python(program, tmp_path) == "None 13000"


def test_a_failed_call_names_file_line_expression_and_error(tmp_path: Path):
    build_library(tmp_path / "libcuda.so.1", stub_driver(13000))
    output = run_python(
        "from haste_cuda import _core\n"
        "try:\n    _core.device_info(3)\nexcept _core.CudaError as error:\n    print(error)",
        tmp_path,
    )
    expected = (
        r"haste_cuda/cuda/device\.cpp:\d+: driver\(\)\.device_get\(&device, ordinal\) "
        r"\[device 3\]: CUDA_ERROR_STUB \(999\), the stub's text"
    )
    assert re.fullmatch(expected, output), output


def test_importing_the_package_starts_no_driver(tmp_path: Path):
    """A driver that ends the process when it is initialised is not noticed by an import."""
    source = stub_driver(13000).replace("(void)flags; return 0;", "(void)flags; _exit(3);")
    build_library(tmp_path / "libcuda.so.1", "#include <unistd.h>\n" + source)
    program = "from haste_cuda import nvrtc; nvrtc.configure(); print('alive')"
    assert run_python(program, tmp_path) == "alive"
