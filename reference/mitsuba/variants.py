"""Which of Mitsuba's variants can run on this machine."""

from __future__ import annotations

import ctypes
import importlib.util

from reference.mitsuba.llvm import select_library


class UnavailableVariantError(RuntimeError):
    """A variant of Mitsuba cannot do here what it was asked to do; the message says why."""


def available(variant: str) -> str | None:
    """None if ``variant`` can run here, else the reason why not.

    For ``llvm_*`` it also chooses the LLVM library, so call it before Dr.Jit's first use.
    """
    if importlib.util.find_spec("mitsuba") is None:
        return "the Python package mitsuba is not installed"
    llvm = select_library()
    import mitsuba as mi

    if variant not in mi.variants():
        return f"Mitsuba has no such variant (it has {', '.join(mi.variants())})"
    if variant.startswith("llvm"):
        return llvm.reason
    if variant.startswith("cuda"):
        return _cuda_reason()
    return None


def _cuda_reason() -> str | None:
    for library in ("libcuda.so.1", "libnvoptix.so.1"):
        try:
            ctypes.CDLL(library)
        except OSError as error:
            return f"NVIDIA's driver library cannot be loaded ({error})"
    driver = ctypes.CDLL("libcuda.so.1")
    count = ctypes.c_int(0)
    if driver.cuInit(0) != 0 or driver.cuDeviceGetCount(ctypes.byref(count)) != 0:
        return "the CUDA driver does not start"
    return None if count.value > 0 else "there is no CUDA device"
