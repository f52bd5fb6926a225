"""The CUDA Monte Carlo ray tracer of Somers and Gibson's Haste, with its twin on the CPU.

One core, compiled by g++ for the CPU and by NVRTC for the GPU: scenes (`Scene`), render settings
(`Settings`) and one function a side (`render_cpu`, `render_cuda`); `trace_cpu`, `trace_cuda` and
`trace_embree` trace rays, which `Rays` holds for many replays, and shade nothing. The extension
imports without a GPU; `cuda_unavailable` then says why.
"""

from haste_cuda._core import (
    Camera,
    CompileError,
    CudaError,
    FilmOverflow,
    Material,
    Rays,
    Scene,
    Settings,
    Shape,
    build_info,
    render_cpu,
)
from haste_cuda.gpu import copy_rates, cuda_unavailable, device_info, render_cuda, trace_cuda
from haste_cuda.rays import trace_cpu, trace_embree

__all__ = [
    "Camera",
    "CompileError",
    "CudaError",
    "FilmOverflow",
    "Material",
    "Rays",
    "Scene",
    "Settings",
    "Shape",
    "build_info",
    "copy_rates",
    "cuda_unavailable",
    "device_info",
    "render_cpu",
    "render_cuda",
    "trace_cpu",
    "trace_cuda",
    "trace_embree",
]
