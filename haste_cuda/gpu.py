"""What needs the GPU: each entry tells the extension first where its compiler and headers are."""

from __future__ import annotations

from typing import Any

from haste_cuda import _core
from haste_cuda.nvrtc import configure
from haste_cuda.rays import held


def cuda_unavailable() -> str | None:
    """Why haste-cuda cannot run here (driver, device, NVRTC), or None."""
    configure()
    return _core.cuda_unavailable()


def device_info(ordinal: int = 0) -> dict[str, Any]:
    """Name, sizes (bytes), clocks (kHz) and driver of a GPU. Raises CudaError without one."""
    configure()
    return _core.device_info(ordinal)


def copy_rates(size: int, repeats: int = 5) -> dict[str, float]:
    """Bytes a second of copies of `size` bytes: see `_core.copy_rates`. Raises CudaError."""
    configure()
    return _core.copy_rates(size, repeats)


def render_cuda(
    scene: _core.Scene, model: str, settings: _core.Settings, **schedule: Any
) -> dict[str, Any]:
    """Render on the GPU: see `_core.render_cuda`, whose keywords `schedule` holds.

    Returns the dict of `render_cpu` with the figures of the kernel. Raises CudaError, CompileError,
    ValueError on settings that make no sense, and FilmOverflow naming the pixel.
    """
    configure()
    return _core.render_cuda(scene, model, settings, **schedule)


def trace_cuda(scene: _core.Scene, *rays: Any, **how: Any) -> dict[str, Any]:
    """Trace rays on the GPU: see `_core.trace_cuda`, whose keywords these are.

    rays: `Rays`, or the arrays that they are made of. Raises CudaError, CompileError, and
    ValueError naming the ray that makes no sense.
    """
    configure()
    return _core.trace_cuda(scene, held(*rays), **how)
