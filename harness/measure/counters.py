"""What a machine says of itself while rays are traced: its clocks, and the energy of its GPU.

NVML is called through the driver's own library, so that no package is needed. The first GPU is the
one that is asked: every tracer runs on it.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

LIBRARY = "libnvidia-ml.so.1"
SM_CLOCK, MEMORY_CLOCK = 1, 2
"""nvmlClockType_t"""


class NvmlError(Exception):
    """NVML is not there, or does not tell; the message is the reason."""


class Nvml:
    """The counters of the first GPU. Raises `NvmlError` where there is none."""

    def __init__(self, library: str = LIBRARY) -> None:
        try:
            self._library: Any = ctypes.CDLL(library)
        except OSError as error:
            raise NvmlError(f"no NVML: {error}") from error
        self._device = ctypes.c_void_p()
        self._call("nvmlInit_v2")
        self._call("nvmlDeviceGetHandleByIndex_v2", 0, ctypes.byref(self._device))

    def _call(self, name: str, *arguments: Any) -> None:
        try:
            code = getattr(self._library, name)(*arguments)
        except AttributeError as error:
            raise NvmlError(f"NVML of this driver has no {name}") from error
        if code:
            describe = self._library.nvmlErrorString
            describe.restype = ctypes.c_char_p
            raise NvmlError(f"{name}: {describe(code).decode()}")

    def clock(self, kind: int) -> int:
        """A clock now, [MHz]."""
        value = ctypes.c_uint()
        self._call("nvmlDeviceGetClockInfo", self._device, kind, ctypes.byref(value))
        return value.value

    def energy(self) -> float:
        """Energy that the GPU has taken since the driver was loaded, [J]."""
        value = ctypes.c_ulonglong()
        self._call("nvmlDeviceGetTotalEnergyConsumption", self._device, ctypes.byref(value))
        return 1e-3 * value.value


@cache
def nvml() -> Nvml | NvmlError:
    """NVML of this process, or why it cannot be had."""
    try:
        return Nvml()
    except NvmlError as error:
        return error


def read_energy() -> float:
    """Energy of the GPU so far, [J]; raises `NvmlError` where it is not told."""
    counters = nvml()
    if isinstance(counters, NvmlError):
        raise counters
    return counters.energy()


def _told(read: Callable[[], int]) -> tuple[int | None, str]:
    try:
        return read(), ""
    except NvmlError as error:
        return None, str(error)


def read_clocks() -> dict[str, Any]:
    """Clocks as they are now, [MHz], None where they are not told; ``reason`` says why not."""
    counters = nvml()
    if isinstance(counters, NvmlError):
        streaming, memory, reason = None, None, str(counters)
    else:
        streaming, reason = _told(lambda: counters.clock(SM_CLOCK))
        memory, _ = _told(lambda: counters.clock(MEMORY_CLOCK))
    processor = _processor_clock()
    if processor is None:
        reason = "; ".join(part for part in (reason, "/proc/cpuinfo tells no clock") if part)
    return {
        "gpu_sm_mhz": streaming,
        "gpu_memory_mhz": memory,
        "processor_mhz": processor,
        "reason": reason,
    }


def _processor_clock(cpuinfo: Path = Path("/proc/cpuinfo")) -> float | None:
    """Mean clock of the processor's cores, [MHz]."""
    try:
        lines = cpuinfo.read_text().splitlines()
    except OSError:
        return None
    clocks = [float(line.partition(":")[2]) for line in lines if line.startswith("cpu MHz")]
    return sum(clocks) / len(clocks) if clocks else None
