"""Counters of the machine: what they tell, and the reason where they do not."""

import ctypes
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from harness.measure import counters
from harness.measure.counters import MEMORY_CLOCK, SM_CLOCK, Nvml, NvmlError, read_clocks


def driver_with(*, tells_energy: bool = True) -> SimpleNamespace:
    """A driver that tells clocks of 1980 and 2619 MHz, and 1.5 J unless it must not."""

    def device(index: int, device: object) -> int:
        del device
        assert index == 0
        return 0

    def clock(device: object, kind: int, value: Any) -> int:
        del device
        value._obj.value = {SM_CLOCK: 1980, MEMORY_CLOCK: 2619}[kind]
        return 0

    def energy(device: object, value: Any) -> int:
        del device
        value._obj.value = 1500
        return 0 if tells_energy else 3

    return SimpleNamespace(
        nvmlInit_v2=lambda: 0,
        nvmlDeviceGetHandleByIndex_v2=device,
        nvmlDeviceGetClockInfo=clock,
        nvmlDeviceGetTotalEnergyConsumption=energy,
        nvmlErrorString=lambda code: f"code {code}".encode(),
    )


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[SimpleNamespace], None]]:
    """Put a driver in the place of the machine's."""

    def put(driver: SimpleNamespace) -> None:
        monkeypatch.setattr(ctypes, "CDLL", {"libnvidia-ml.so.1": driver}.__getitem__)
        counters.nvml.cache_clear()

    yield put
    counters.nvml.cache_clear()


def test_clocks_are_megahertz_and_energy_is_joules(install: Callable[[SimpleNamespace], None]):
    install(driver_with())
    clocks = read_clocks()
    assert (clocks["gpu_sm_mhz"], clocks["gpu_memory_mhz"]) == (1980, 2619)
    assert Nvml().energy() == 1.5


def test_what_a_driver_does_not_tell_is_an_error_with_its_words(
    install: Callable[[SimpleNamespace], None],
):
    install(driver_with(tells_energy=False))
    with pytest.raises(NvmlError, match="nvmlDeviceGetTotalEnergyConsumption: code 3"):
        counters.read_energy()


def test_a_machine_without_a_driver_tells_no_clocks_of_a_gpu_and_says_why():
    with pytest.raises(NvmlError, match=re.escape("no NVML: libnothing.so.7")):
        Nvml("libnothing.so.7")


def test_the_clock_of_the_processor_is_the_mean_of_its_cores(tmp_path: Path):
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text("model name\t: none\ncpu MHz\t\t: 2000.0\ncpu MHz\t\t: 3000.0\n")
    assert counters._processor_clock(cpuinfo) == 2500.0
    cpuinfo.write_text("model name\t: none\n")
    assert counters._processor_clock(cpuinfo) is None
