"""Thumbnails: their size in pixels and bytes, and what they are rendered with."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PillowImage

from harness.scene import load_scene
from harness.thumbnails import MAX_BYTES, encode_thumbnail, render_thumbnail, thumbnail_size

SCENE = """
<scene version="3.0.0">
    <default name="fov" value="1"/>
    <sensor type="perspective">
        <float name="fov" value="$fov"/>
    </sensor>
    <shape type="sphere">
        <point name="center" x="0" y="0" z="5"/>
        <emitter type="area"/>
    </shape>
</scene>
"""


@pytest.mark.parametrize(
    ("picture", "expected"),
    [
        ((512, 512), (192, 192)),
        ((768, 512), (192, 128)),
        ((100, 300), (64, 192)),
        ((8, 8), (192, 192)),
    ],
)
def test_the_longer_side_has_192_pixels(
    picture: tuple[int, int], expected: tuple[int, int]
) -> None:
    assert thumbnail_size(picture) == expected


def test_noise_is_encoded_within_the_limit() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (192, 192, 3), np.uint8)
    data = encode_thumbnail(noise)
    assert len(data) <= MAX_BYTES
    assert PillowImage.open(io.BytesIO(data)).size == (192, 192)


def test_a_plain_picture_keeps_its_colours() -> None:
    ramp = np.zeros((192, 192, 3), np.uint8)
    ramp[..., 1] = np.arange(192)[None, :]
    kept = np.asarray(PillowImage.open(io.BytesIO(encode_thumbnail(ramp))).convert("RGB"))
    assert np.abs(kept.astype(int) - ramp).max() <= 2


def write_scene(folder: Path, settings: str) -> Path:
    (folder / "scene.xml").write_text(SCENE)
    (folder / "settings.yaml").write_text(settings)
    return folder


def test_parameters_of_the_picture_widen_the_view_of_the_thumbnail_alone(tmp_path: Path) -> None:
    folder = write_scene(tmp_path, "picture: [8, 8]\npicture_parameters: {fov: 60}\n")
    radiance = render_thumbnail(folder, threads=1, samples=1)
    # The ball fills the field of view of one degree, and not that of 60.
    assert radiance.shape == (192, 192, 3)
    assert (radiance == 0.0).mean() > 0.5
    assert radiance[96, 96] == pytest.approx([1.0, 1.0, 1.0])
    narrow, wide = (
        np.linalg.norm(load_scene(folder, 8, 8, parameters=parameters).camera.dx)
        for parameters in (None, {"fov": "60"})
    )
    assert wide / narrow == pytest.approx(np.tan(np.radians(30.0)) / np.tan(np.radians(0.5)))


def test_a_parameter_that_the_scene_does_not_have_is_refused(tmp_path: Path) -> None:
    folder = write_scene(tmp_path, "picture_parameters: {zoom: 2}\n")
    with pytest.raises(ValueError, match="zoom"):
        render_thumbnail(folder, threads=1, samples=1)
