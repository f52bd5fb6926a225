"""Tone mapping and error colours."""

import io

import numpy as np
import pytest
from PIL import Image

from harness.report import picture
from harness.statistics.metrics import make_truth


def test_srgb_has_its_published_values():
    grey = np.array([0.0, 0.0031308, 0.2158605, 1.0])[:, None, None] * np.ones((4, 1, 3))
    assert picture.encode_srgb(grey)[:, 0, 0].tolist() == [0, 10, 128, 255]


def test_a_pixel_that_is_not_finite_is_magenta():
    image = np.zeros((1, 2, 3))
    image[0, 1, 2] = np.nan
    assert picture.encode_srgb(image).tolist() == [[[0, 0, 0], [255, 0, 255]]]


def test_exposure_does_not_depend_on_the_unit_of_radiance():
    image = np.random.default_rng(1).uniform(0.1, 1.0, (16, 16, 3))
    shown = picture.encode_srgb(image * picture.exposure_of(image))
    scaled = picture.encode_srgb(1e4 * image * picture.exposure_of(1e4 * image))
    np.testing.assert_array_equal(shown, scaled)
    assert picture.exposure_of(np.zeros((4, 4, 3))) == 1.0


def test_a_light_does_not_darken_the_scene():
    image = np.full((20, 20, 3), 0.5)
    image[:2] = 100.0
    assert 0.1 < 0.5 * picture.exposure_of(image) < 1.0


def test_error_colours_are_blue_below_white_at_and_red_above_zero():
    low, zero, high = picture.colour_errors(np.array([-1.0, 0.0, 1.0]), 1.0).astype(int)
    assert low[2] > low[0] + 50
    assert high[0] > high[2] + 50
    assert zero.min() > 240
    beyond = picture.colour_errors(np.array([5.0]), 1.0)[0]
    assert beyond.tolist() == high.tolist()


@pytest.mark.parametrize(
    ("top", "limit"), [(0.011, 0.02), (0.02, 0.02), (0.3, 0.5), (0.7, 1.0), (0.0, 1e-6)]
)
def test_the_scale_ends_at_one_two_or_five(top: float, limit: float):
    assert picture.error_range([np.full((8, 8), top)]) == pytest.approx(limit)


def test_relative_error_is_finite_where_the_truth_is_black():
    truth = make_truth(np.concatenate([np.zeros((2, 4, 4, 3)), np.ones((2, 4, 4, 3))], axis=2))
    error = picture.relative_error(truth.mean + 0.1, truth)
    assert np.isfinite(error).all()
    assert error[0, -1] == pytest.approx(0.1, rel=0.01)


def test_a_picture_is_encoded_pixel_by_pixel():
    image = np.zeros((2, 3, 3))
    image[0, 0] = 1.0
    with Image.open(io.BytesIO(picture.encode_png(picture.encode_srgb(image)))) as shown:
        assert shown.size == (3, 2)
        pixels = np.asarray(shown)
    assert pixels[0, 0].min() == 255
    assert pixels[1:].max() == 0
