"""The imported camera against Mitsuba's own sensor."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np
import pytest

from harness.scene import active_variant, load_scene, parse_scene, parser_config
from harness.scene.records import Camera

BODY = '<shape type="cube"/>'
# Mitsuba rounds its matrices to float32: a few times 2^-24 in each component.
DIRECTION_TOLERANCE = 1e-6


def sensor(settings: str, film: str, to_world: str = "") -> str:
    placed = to_world or '<lookat origin="1,-5,2" target="0.2,0.1,-0.3" up="0.1,0,1"/>'
    return (
        f'<sensor type="perspective">{settings}<transform name="to_world">{placed}</transform>'
        f'<film type="hdrfilm">{film}</film></sensor>'
    )


def size(width: int, height: int, crop: tuple[int, int, int, int] | None = None) -> str:
    names = {"width": width, "height": height}
    if crop is not None:
        keys = ("crop_offset_x", "crop_offset_y", "crop_width", "crop_height")
        names |= dict(zip(keys, crop, strict=True))
    return "".join(f'<integer name="{key}" value="{value}"/>' for key, value in names.items())


def our_ray(camera: Camera, x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    along = np.array(camera.corner) + x * np.array(camera.dx) + y * np.array(camera.dy)
    origin = np.array(camera.origin) + camera.near * along
    return origin, along / np.linalg.norm(along)


def assert_rays_agree(file: Any, width: int | None = None, height: int | None = None) -> None:
    camera = load_scene(file, width, height).camera
    state = parse_scene(file, "scalar_rgb", width=width, height=height, integrator={"type": "path"})
    generator = np.random.default_rng(7)
    with active_variant("scalar_rgb"):
        built = mi.parser.instantiate(parser_config("scalar_rgb"), state).sensors()[0]
        assert list(built.film().crop_size()) == [camera.width, camera.height]
        for u, v in [(0.0, 0.0), (1.0, 1.0), *generator.random((20, 2))]:
            ray, _ = built.sample_ray(0.0, 0.5, mi.ScalarPoint2f(u, v), mi.ScalarPoint2f(0.5))
            origin, along = our_ray(camera, u * camera.width, v * camera.height)
            message = (u, v, camera, np.array(ray.d), along)
            assert np.abs(np.array(ray.d) - along).max() < DIRECTION_TOLERANCE, message
            assert np.abs(np.array(ray.o) - origin).max() < 1e-6 * 5.0, message


@pytest.mark.parametrize("axis", ["x", "y", "diagonal", "smaller", "larger"])
@pytest.mark.parametrize("shape", [(40, 30), (30, 40)])
def test_rays_agree_for_every_fov_axis(write_scene: Any, axis: str, shape: tuple[int, int]) -> None:
    settings = f'<float name="fov" value="50"/><string name="fov_axis" value="{axis}"/>'
    assert_rays_agree(write_scene(BODY, sensor=sensor(settings, size(*shape))))


@pytest.mark.parametrize(
    "settings",
    ["", '<string name="focal_length" value="35mm"/>', '<float name="near_clip" value="0.5"/>'],
)
def test_rays_agree_for_focal_lengths_and_near_planes(write_scene: Any, settings: str) -> None:
    assert_rays_agree(write_scene(BODY, sensor=sensor(settings, size(40, 30))))


def test_rays_agree_with_crop_and_principal_point(write_scene: Any) -> None:
    settings = (
        '<float name="fov" value="60"/><float name="principal_point_offset_x" value="0.13"/>'
        '<float name="principal_point_offset_y" value="-0.21"/>'
    )
    film = size(40, 30, crop=(10, 6, 20, 12))
    assert_rays_agree(write_scene(BODY, sensor=sensor(settings, film)))


def test_rays_agree_when_size_and_crop_are_scaled(write_scene: Any) -> None:
    film = size(40, 30, crop=(10, 6, 20, 12))
    file = write_scene(BODY, sensor=sensor('<float name="fov" value="60"/>', film))
    assert_rays_agree(file, 40, 24)
    camera, scaled = load_scene(file).camera, load_scene(file, 40, 24).camera
    assert (scaled.width, scaled.height) == (40, 24)
    assert scaled.corner == pytest.approx(camera.corner)


def test_rays_agree_under_a_to_world_that_is_no_lookat(write_scene: Any) -> None:
    placed = '<rotate y="0.6" z="0.8" angle="70"/><translate x="3" y="1" z="2"/>'
    film = size(24, 24)
    assert_rays_agree(
        write_scene(BODY, sensor=sensor('<float name="fov" value="35"/>', film, placed))
    )


def test_a_perturbed_camera_is_noticed(write_scene: Any) -> None:
    camera = load_scene(write_scene(BODY)).camera
    _, along = our_ray(camera, 3.0, 4.0)
    _, shifted = our_ray(camera, 3.01, 4.0)
    assert np.abs(along - shifted).max() > 10 * DIRECTION_TOLERANCE
