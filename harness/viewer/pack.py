"""The viewer's data: in the page, or as scripts and EXR files beside a page that is unpacked."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from harness.report.picture import colour_errors
from harness.statistics.metrics import LUMINANCE
from harness.tables.read import read_jobs
from harness.viewer.halves import encode, exponent_of, to_halves
from harness.viewer.panels import (
    Moments,
    Panel,
    images_of,
    make_panel,
    panels_in_order,
)
from harness.whole_files import write_whole, written_whole

HERE = Path(__file__).parent
SCRIPTS = (
    "data.js",
    "student.js",
    "errors.js",
    "flip.js",
    "colour.js",
    "modes.js",
    "geometry.js",
    "webgl.js",
    "canvas.js",
    "link.js",
    "stage.js",
    "readout.js",
    "pointer.js",
    "keyboard.js",
    "controls.js",
    "main.js",
)
"""In the order in which they need each other; classic scripts, since modules need a server."""
INLINE_BYTES = 8_000_000
"""What the images in the page may take."""
SHADES = 256
"""Entries of a colour map."""
FULL_SIZE = "report.zip"
"""Where images are that the page has no room for."""


@cache
def colour_maps() -> dict[str, str]:
    """Colour-blind-safe maps, as hexadecimal RGB of SHADES entries.

    `signed`: ColorBrewer's RdBu, as the report's error maps; `magnitude`: magma (van der Walt and
    Smith 2015), of even steps in lightness.
    """
    signed = colour_errors(np.linspace(-1.0, 1.0, SHADES), 1.0)
    magma = mpl.colormaps["magma"](np.linspace(0.0, 1.0, SHADES), bytes=True)[:, :3]
    return {"signed": signed.tobytes().hex(), "magnitude": magma.tobytes().hex()}


def _describe_image(moments: Moments) -> dict[str, Any]:
    return {
        "name": moments.name,
        "count": moments.count,
        "spp": moments.spp,
        "exponent": exponent_of(moments),
    }


def _describe(panel: Panel, script: str | None) -> dict[str, Any]:
    return {
        "scene": panel.scene,
        "title": panel.title,
        "model": panel.model,
        "width": panel.width,
        "height": panel.height,
        "block": panel.block,
        "exposure": panel.exposure,
        "epsilon": panel.epsilon,
        "flip": asdict(panel.flip),
        "limits": asdict(panel.limits),
        "images": [_describe_image(moments) for moments in panel.images],
        "script": script,
    }


def _context(
    panels: Sequence[dict[str, Any]],
    blobs: Sequence[tuple[str, str]],
    elsewhere: Sequence[tuple[str, str, str]],
) -> dict[str, Any]:
    catalogue = {
        "luminance": LUMINANCE.tolist(),
        "maps": colour_maps(),
        "panels": panels,
        "elsewhere": [
            {"scene": scene, "title": title, "model": model} for scene, title, model in elsewhere
        ],
        "full_size": FULL_SIZE,
    }
    # "</script>" within a title must not end the script that holds it.
    text = json.dumps(catalogue, separators=(",", ":")).replace("<", "\\u003c")
    return {
        "css": (HERE / "viewer.css").read_text(),
        "scripts": [(HERE / name).read_text() for name in SCRIPTS],
        "catalogue": text,
        "blobs": blobs,
        "shown": len(panels),
        "elsewhere": len(elsewhere),
    }


def viewer_context(
    results_dir: Path,
    limit: int = 100,
    side: int = 128,
    first: Sequence[tuple[str, str]] = (),
) -> dict[str, Any]:
    """What viewer.html.j2 needs for a page that holds its images.

    Parameters
    ----------
    results_dir
        Folder of a run.
    limit
        Images at most, truths counted. Scenes are whole in a model, or not there.
    side
        Pixels of an image's longer side at most; larger images become means of squares of pixels.
    first
        Scene and model of panels that come before all others, such as those that failed.

    Raises
    ------
    ResultsError
        For missing or damaged files.
    """
    panels, blobs, elsewhere = [], [], []
    images = size = 0
    for job, model in panels_in_order(read_jobs(results_dir), tuple(first)):
        count = images_of(job, model)
        if not count:
            continue
        panel = make_panel(job, model, side) if images + count <= limit else None
        lines = [encode(to_halves(moments)) for moments in panel.images] if panel else []
        length = sum(len(line) + 1 for line in lines)
        if panel is None or size + length > INLINE_BYTES:
            elsewhere.append((job.name, job.title, model))
            continue
        images, size = images + count, size + length
        panels.append(_describe(panel, None))
        blobs.append((panel.key, "\n".join(lines)))
    return _context(panels, blobs, elsewhere)


def write_full_size(results_dir: Path, folder: Path) -> dict[str, Any]:
    """Write every image at full size, and return what viewer.html.j2 needs for a page beside them.

    ``viewer/<scene>.<model>.js`` holds what the viewer shows, as scripts: a page opened from a disk
    may read nothing else. ``images/<scene>/<model>/<tracer>.exr`` holds the same in float32: mean
    radiance in R, G and B, and the standard error of its luminance in `sigma`.

    Raises
    ------
    ResultsError
        For missing or damaged files.
    OSError
        If the folder cannot be written.
    """
    panels = []
    jobs = read_jobs(results_dir)
    for job, model in panels_in_order(jobs, ()):
        panel = make_panel(job, model)
        if panel is None:
            continue
        script = f"viewer/{file_name(panel.scene)}.{file_name(panel.model)}.js"
        lines = [encode(to_halves(moments)) for moments in panel.images]
        call = f"hasteViewer.register({json.dumps(panel.key)}, {json.dumps(lines)});\n"
        write_whole(folder / script, call)
        place = folder / "images" / file_name(panel.scene) / file_name(panel.model)
        for moments in panel.images:
            write_exr(place / f"{file_name(moments.name)}.exr", moments)
        panels.append(_describe(panel, script))
    return _context(panels, [], [])


def file_name(name: str) -> str:
    """A name of a scene, model or tracer as a file's, the same on every system."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", name)


def write_exr(path: Path, moments: Moments) -> None:
    """Write an image's mean and the standard error of its luminance as an EXR of float32."""
    import OpenEXR

    channels: dict[str, NDArray[np.float32]] = {
        "RGB": np.ascontiguousarray(moments.mean),
        "sigma": np.ascontiguousarray(moments.sigma),
    }
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with written_whole(path) as (temporary,):
        OpenEXR.File(header, channels).write(str(temporary))
