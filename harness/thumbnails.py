"""Small pictures of the scenes, as their READMEs show them."""

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from harness.report.picture import encode_srgb, exposure_of
from harness.scene import load_scene, load_settings

FILE = "thumbnail.png"
LONGER_SIDE = 192
"""Pixels."""
SAMPLES = 128
"""A pixel."""
MAX_BYTES = 25_000
"""What a thumbnail may take in the repository."""
COLOURS = (256, 192, 128, 96, 64, 48, 32, 24, 16)
"""Sizes of the palette, tried in turn until the file is small enough."""


def thumbnail_size(picture: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a thumbnail in the proportions of a scene's picture, in pixels."""
    longer = max(picture)
    width, height = (max(1, round(LONGER_SIDE * side / longer)) for side in picture)
    return width, height


def render_thumbnail(folder: Path, threads: int, samples: int = SAMPLES) -> NDArray[np.float64]:
    """Radiance [h, w, 3] of a scene, by haste-cpu in `path`, or else in the scene's first model."""
    import haste_cuda
    from harness.tracers.haste import to_core, to_core_settings

    settings = load_settings(folder)
    width, height = thumbnail_size(settings.picture)
    scene = load_scene(
        folder,
        width=width,
        height=height,
        recentre=settings.recentre,
        parameters=settings.picture_parameters,
    )
    model = "path" if "path" in settings.models else settings.models[0]
    answer = haste_cuda.render_cpu(
        to_core(scene, threads),
        model,
        to_core_settings(settings.render(model, width, height)),
        threads=threads,
        seed=0,
        samples=samples,
    )
    return np.asarray(answer["film"], dtype=np.float64)


def encode_thumbnail(pixels: NDArray[np.uint8]) -> bytes:
    """8-bit RGB [h, w, 3] as a PNG with a palette, of as many colours as fit into `MAX_BYTES`.

    Raises ValueError if it does not fit with the fewest.
    """
    image = PillowImage.fromarray(pixels)
    for colours in COLOURS:
        buffer = io.BytesIO()
        reduced = image.quantize(colours, dither=PillowImage.Dither.NONE)
        reduced.save(buffer, format="PNG", optimize=True)
        if buffer.tell() <= MAX_BYTES:
            return buffer.getvalue()
    raise ValueError(f"{buffer.tell()} bytes with {COLOURS[-1]} colours, more than {MAX_BYTES}")


def write_thumbnail(folder: Path, threads: int, samples: int = SAMPLES) -> Path:
    """Render a scene's thumbnail and write it into its folder, exposed as in the report."""
    radiance = render_thumbnail(folder, threads, samples)
    path = folder / FILE
    path.write_bytes(encode_thumbnail(encode_srgb(radiance * exposure_of(radiance))))
    return path
