"""Where and from what a run's numbers come."""

import hashlib
import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from harness.measure.config import CONVERGENCE_SEED, ROOT, Config
from harness.measure.files import hash_files
from harness.measure.inputs import extension_path
from harness.scene import Scene

PACKAGES = (
    "mitsuba",
    "drjit",
    "numpy",
    "pandas",
    "pyarrow",
    "scipy",
    "matplotlib",
    "OpenEXR",
    "jinja2",
    "jsonschema",
    "snakemake",
    "nvidia-cuda-nvrtc",
)
GPU_FIELDS = (
    "name",
    "uuid",
    "driver_version",
    "clocks.sm",
    "clocks.mem",
    "clocks.max.sm",
    "temperature.gpu",
    "power.draw",
    "power.limit",
    "memory.total",
    "mig.mode.current",
)
SOURCES = ("harness/scene", "harness/tracers", "haste_cuda", "reference")
"""Folders whose Python, C++ and CUDA decide what an image looks like."""


def _output(*command: str) -> str | None:
    if shutil.which(command[0]) is None:
        return None
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() if done.returncode == 0 else None


def sources() -> list[Path]:
    """List the files whose content decides what an image looks like."""
    patterns = ("*.py", "*.h", "*.cuh", "*.cpp")
    files = {
        path
        for folder in SOURCES
        for pattern in patterns
        for path in (ROOT / folder).rglob(pattern)
    }
    extension = extension_path()
    return sorted(files | ({extension} if extension else set()))


def version_of(package: str) -> str | None:
    """Version of an installed package, None where it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def tracer_code(tracer: str) -> str:
    """Hash the code that a tracer's images come from: our sources and what they call."""
    files = [*(ROOT / "harness" / "scene").rglob("*.py"), ROOT / "harness/tracers/base.py"]
    if tracer.startswith("mitsuba"):
        files += [*(ROOT / "reference/mitsuba").rglob("*.py"), ROOT / "harness/tracers/mitsuba.py"]
        versions = f"{version_of('mitsuba')} {version_of('drjit')}"
    else:
        # Kernels for the GPU are compiled from the headers at run time.
        files += [ROOT / "harness/tracers/haste.py", *(ROOT / "haste_cuda").glob("*.py")]
        files += [*(ROOT / "haste_cuda").rglob("*.h"), *(ROOT / "haste_cuda").rglob("*.cuh")]
        extension = extension_path()
        files += [extension] if extension else []
        versions = ""
    return hashlib.sha256(f"{hash_files(files)} {versions}".encode()).hexdigest()


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _governor() -> str | None:
    path = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    return path.read_text().strip() if path.is_file() else None


def _gpus() -> list[dict[str, str]]:
    text = _output(
        "nvidia-smi", f"--query-gpu={','.join(GPU_FIELDS)}", "--format=csv,noheader,nounits"
    )
    return [
        dict(zip(GPU_FIELDS, (value.strip() for value in line.split(",")), strict=False))
        for line in (text or "").splitlines()
    ]


def _extension() -> dict[str, Any] | None:
    path = extension_path()
    if path is None:
        return None
    try:
        import haste_cuda
    except ImportError as error:
        return {"unusable": str(error)}
    return {
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "build": dict(haste_cuda.build_info()),
        "device": dict(haste_cuda.device_info()) if not haste_cuda.cuda_unavailable() else None,
    }


def commit() -> tuple[str | None, bool | None]:
    """Commit of the repository, and whether tracked files differ from it; None without git."""
    head = _output("git", "rev-parse", "HEAD")
    status = _output("git", "status", "--porcelain", "--untracked-files=no")
    return head, None if status is None else bool(status)


def arithmetic() -> dict[str, bool]:
    """Probe what single precision really does in this process, whatever it was compiled for.

    A library that was linked with fast arithmetic flushes subnormal numbers to zero for the whole
    process.
    """
    least = np.finfo(np.float32).tiny
    one, three, half = np.float32(1.0), np.float32(3.0), np.float32(0.5)
    return {
        "subnormals": bool(least * half > 0.0),
        "quotients_round_to_nearest": bool((one / three).view(np.uint32) == 0x3EAAAAAB),
        "roots_round_to_nearest": bool(np.sqrt(three - one).view(np.uint32) == 0x3FB504F3),
        "nan_is_unequal": bool(np.isnan(np.float32(np.nan))),
    }


def machine() -> dict[str, Any]:
    """Describe the machine as it is now."""
    load = os.getloadavg()
    return {
        "system": platform.platform(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "usable_cores": len(os.sched_getaffinity(0)),
        "governor": _governor(),
        "load_average": list(load),
        # Somebody else's work on the machine would be in every time that follows.
        "contended": load[0] > 0.5 * len(os.sched_getaffinity(0)),
        "gpus": _gpus(),
    }


def provenance(config: Config, scene: Scene, threads: int) -> dict[str, Any]:
    """Describe what a scene's job is about to do, where, and with what.

    Parameters
    ----------
    config
        The run's settings.
    scene
        The scene.
    threads
        Processor threads given to every tracer.

    Returns
    -------
    dict
        JSON-serialisable.
    """
    head, dirty = commit()
    return {
        "run": config["preset"],
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": head,
        "dirty": dirty,
        "command": ["python", "-m", "harness", *sys.argv[1:]],
        "machine": machine(),
        "arithmetic": arithmetic(),
        "threads": threads,
        "python": platform.python_version(),
        "packages": {name: version_of(name) for name in PACKAGES},
        "extension": _extension(),
        "config": config.values,
        "scene": {
            "name": scene.name,
            "sha256": scene.sha256,
            "features": asdict(scene.features),
        },
        "seeds": {
            "tracers": [0, config["seeds"]["count"] - 1],
            "convergence_first": CONVERGENCE_SEED,
            "truth_first": config["truth"]["seed"],
        },
        "sources_sha256": hash_files(sources()),
    }
