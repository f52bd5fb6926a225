"""Small pictures of the scenes, as their READMEs show them."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from harness.report.picture import encode_srgb, exposure_of
from harness.scene import load_scene, load_settings
from harness.whole_files import write_whole

FILE = "thumbnail.png"
LONGER_SIDE = 192
"""Pixels."""
SAMPLES = 128
"""A pixel."""
MAX_BYTES = 25_000
"""What a thumbnail may take in the repository."""
COLOURS = (256, 192, 128, 96, 64, 48, 32, 24, 16)
"""Sizes of the palette, tried in turn until the file is small enough."""

SHEET_SCENES = (
    "skull",
    "cart",
    "head",
    "three-spheres",
    "mirror-glass",
    "cornell-box",
    "veach-mis",
    "hard",
    "bunny",
    "armadillo",
    "sphereflake",
    "menger-4",
    "teapot",
    "tetra",
    "balls",
    "teapot-stadium",
)
"""Those of the sheet, the paper's own first."""
SHEET_COLUMNS = 8
SHEET_SIDE = 152
"""Pixels of one picture of the sheet."""
SHEET_GAP = 4


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
    write_whole(path, encode_thumbnail(encode_srgb(radiance * exposure_of(radiance))))
    return path


def write_sheet(folders: Sequence[Path], path: Path) -> Path:
    """Write the thumbnails of some scenes side by side, as the README shows them.

    Raises FileNotFoundError naming a thumbnail that is not there.
    """
    pitch = SHEET_SIDE + SHEET_GAP
    rows = -(-len(folders) // SHEET_COLUMNS)
    size = (SHEET_COLUMNS * pitch - SHEET_GAP, rows * pitch - SHEET_GAP)
    sheet = PillowImage.new("RGB", size, "white")
    for index, folder in enumerate(folders):
        with PillowImage.open(folder / FILE) as image:
            small = image.convert("RGB")
        small.thumbnail((SHEET_SIDE, SHEET_SIDE), PillowImage.Resampling.LANCZOS)
        row, column = divmod(index, SHEET_COLUMNS)
        left = column * pitch + (SHEET_SIDE - small.width) // 2
        top = row * pitch + (SHEET_SIDE - small.height) // 2
        sheet.paste(small, (left, top))
    # Not a palette as for one thumbnail: together they have too many colours.
    content = io.BytesIO()
    sheet.save(content, format="JPEG", quality=90, optimize=True)
    write_whole(path, content.getvalue())
    return path
