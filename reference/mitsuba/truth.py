"""The ground truth of one scene in one model: independent batches, their mean and their variance.

A truth is only as good as what is known of its own noise, so it is never one long render: every
batch has its own seed, and the variance over batches says how far the mean may be off.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import harness.scene
from harness.scene import (
    RenderSettings,
    SceneSource,
    check_model,
    load_scene,
    parse_scene,
)
from harness.whole_files import write_array, write_whole, written_whole
from reference.mitsuba.llvm import select_library
from reference.mitsuba.rendering import LoadedScene, is_recentred, load, render
from reference.mitsuba.variants import UnavailableVariantError, available

FIRST_SEED = 1_000_000
MIN_BATCHES = 16
"""Fewer batches leave the variance of the mean, and so every verdict, too uncertain."""

VARIANT = "llvm_ad_rgb"
FALLBACK_VARIANT = "scalar_rgb"

MEAN, VARIANCE, RECORD = "mean.exr", "variance.exr", "truth.json"


def render_truth(
    source: SceneSource,
    settings: RenderSettings,
    *,
    batches: int,
    spp: int,
    out_dir: Path,
    seed: int = FIRST_SEED,
    threads: int | None = None,
    progress: Callable[[str], object] = lambda _: None,
) -> dict[str, Any]:
    """Renders what is missing of a ground truth.

    Parameters
    ----------
    source
        Scene folder, XML file or Mitsuba dictionary.
    settings
        Model and its settings.
    batches
        How many independent images, at least 16; batch k has the seed ``seed + k``.
    spp
        Samples a pixel of one batch.
    out_dir
        Receives batch_000.npy ... (float32 [h, w, 3]), mean.exr, variance.exr (of one batch, per
        pixel and channel, over batches) and truth.json. Each appears whole or not at all. Batches
        that are there from the same scene, settings and code are kept.
    seed
        Of the first batch. Tests and comparisons use other seeds than truths.
    threads
        Processor threads; None leaves Dr.Jit's own choice.
    progress
        Called with a line of text after each batch.

    Returns
    -------
    dict
        What truth.json holds: the key, the settings and the provenance.

    Raises
    ------
    UnavailableVariantError
        If no variant of Mitsuba can render the scene here; the message says what to install.
    SceneError
        If the scene cannot be read, or not be rendered with the model.
    """
    if batches < MIN_BATCHES:
        raise ValueError(f"a truth has at least {MIN_BATCHES} batches, not {batches}")
    out_dir = Path(out_dir)
    record = _describe(source, settings, batches, spp, seed)
    paths = [out_dir / f"batch_{k:03d}.npy" for k in range(batches)]
    shape = (settings.height, settings.width, 3)
    written = _read_record(out_dir)
    same = written.get("key") == record["key"] and written.get("complete")
    if same and all(path.is_file() for path in [*paths, out_dir / MEAN, out_dir / VARIANCE]):
        return written
    out_dir.mkdir(parents=True, exist_ok=True)
    if written.get("batch_key") != record["batch_key"]:
        _remove(out_dir.glob("batch_*.npy"))
    _remove([out_dir / MEAN, out_dir / VARIANCE])
    _remove(path for path in out_dir.glob("batch_*.npy") if path not in paths)
    _write_record(out_dir, record)
    loaded: LoadedScene | None = None
    for k, path in enumerate(paths):
        if _read_batch(path, shape) is not None:
            continue
        if loaded is None:
            loaded = _load(source, settings, record["variant"], threads)
        start = time.perf_counter()
        image, _ = render(loaded, seed + k, spp)
        _check_finite(image, f"batch {k} of {record['scene']}, {settings.model}")
        _write_batch(path, image)
        progress(f"batch {k + 1} of {batches}: {time.perf_counter() - start:.2f} s")
    images = np.stack([np.load(path) for path in paths]).astype(np.float64)
    _write_exr(out_dir / MEAN, images.mean(axis=0))
    _write_exr(out_dir / VARIANCE, images.var(axis=0, ddof=1))
    record["complete"] = True
    _write_record(out_dir, record)
    return record


def choose_variant(source: SceneSource, settings: RenderSettings) -> str:
    """The variant that renders the truth of a scene: LLVM's, or the scalar one where it suffices.

    Raises
    ------
    UnavailableVariantError
        If LLVM is missing and the scene needs Python plug-ins, which scalar variants do not run.
    """
    reason = available(VARIANT)
    if reason is None:
        return VARIANT
    if settings.model != "path":
        raise UnavailableVariantError(f"the truth of the model {settings.model}: {reason}")
    state = parse_scene(source, FALLBACK_VARIANT)
    if any(node.props.plugin_name() == "phong" for node in state.nodes):
        raise UnavailableVariantError(f"the truth of a scene with the BSDF phong: {reason}")
    return FALLBACK_VARIANT


def _describe(
    source: SceneSource, settings: RenderSettings, batches: int, spp: int, seed: int
) -> dict[str, Any]:
    """The record of a truth still to be rendered: keys, settings and provenance."""
    recentre = is_recentred(source)
    variant = choose_variant(source, settings)
    scene = load_scene(source, width=settings.width, height=settings.height, recentre=recentre)
    check_model(scene, settings.model)
    of_a_batch = {
        "scene_sha256": scene.sha256,
        "recentre": recentre,
        "settings": asdict(settings) | {"ambient": list(settings.ambient)},
        "spp": spp,
        "seed": seed,
        "variant": variant,
        "mitsuba": importlib.metadata.version("mitsuba"),
        "drjit": importlib.metadata.version("drjit"),
        "code_sha256": code_hash(),
    }
    return {
        "key": _hash({**of_a_batch, "batches": batches}),
        "batch_key": _hash(of_a_batch),
        "complete": False,
        "scene": scene.name,
        "batches": batches,
        **of_a_batch,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "llvm": select_library().path if variant == VARIANT else None,
        "machine": platform.platform(),
    }


def code_hash() -> str:
    """SHA-256 of the source text that a truth comes from."""
    scene = Path(harness.scene.__file__).parent
    files = sorted(Path(__file__).parent.glob("*.py"))
    files += [scene / "parse.py", scene / "recentre.py"]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def _hash(parts: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _load(
    source: SceneSource, settings: RenderSettings, variant: str, threads: int | None
) -> LoadedScene:
    import drjit as dr

    if threads is not None:
        dr.set_thread_count(threads)
    return load(source, settings, variant)


def _read_record(out_dir: Path) -> dict[str, Any]:
    try:
        record = json.loads((out_dir / RECORD).read_text())
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def _read_batch(path: Path, shape: tuple[int, ...]) -> NDArray[np.float32] | None:
    try:
        image = np.load(path)
    except (OSError, ValueError, EOFError):
        return None
    return image if image.shape == shape and image.dtype == np.float32 else None


def _write_batch(path: Path, image: NDArray[np.float64]) -> None:
    write_array(path, image.astype(np.float32))


def _check_finite(image: NDArray[np.float64], what: str) -> None:
    bad = np.argwhere(~np.isfinite(image).all(axis=2))
    if len(bad):
        y, x = bad[0]
        raise FloatingPointError(
            f"{what}: {len(bad)} pixels are not finite, the first at x = {x}, y = {y}"
        )


def _remove(paths: Any) -> None:
    for path in paths:
        path.unlink(missing_ok=True)


def _write_record(out_dir: Path, record: Mapping[str, Any]) -> None:
    write_whole(out_dir / RECORD, json.dumps(record, indent=1) + "\n")


def _write_exr(path: Path, image: NDArray[np.float64]) -> None:
    """Writes a float32 RGB image with ZIP compression, which loses nothing."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {"RGB": np.ascontiguousarray(image, dtype=np.float32)}
    with written_whole(path) as (temporary,):
        OpenEXR.File(header, channels).write(str(temporary))
