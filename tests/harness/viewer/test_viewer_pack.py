"""The viewer's data: half floats, what the page has room for, and the files beside it."""

import base64
import json
import zlib
from collections.abc import Callable
from pathlib import Path

import flip_evaluator
import numpy as np
import OpenEXR
import pytest

from harness.statistics.metrics import luminance
from harness.tables.read import read_jobs
from harness.viewer import pack
from harness.viewer.exposures import pin_exposures
from harness.viewer.halves import DIMMEST, LARGEST, encode, exponent_of, to_halves
from harness.viewer.links import link_of, worst_place
from harness.viewer.pack import HERE, SCRIPTS, file_name, viewer_context, write_full_size
from harness.viewer.panels import Moments, block_means, make_panel, moments_of

LONGEST_FILE = 400


def moments(mean: np.ndarray, sigma: np.ndarray | None = None) -> Moments:
    sigma = np.zeros(mean.shape[:2]) if sigma is None else sigma
    return Moments("x", mean.astype(np.float32), sigma.astype(np.float32), 16, 64)


def decode(text: str, shape: tuple[int, int]) -> np.ndarray:
    data = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, -1)
    return np.ascontiguousarray(data.T).view("<f2").reshape(4, *shape)


def catalogue(context: dict) -> dict:
    return json.loads(context["catalogue"])


def test_halves_survive_the_way_through_text():
    random = np.random.default_rng(1)
    mean = random.lognormal(0.0, 3.0, (7, 5, 3))
    mean[0, 0, 0], mean[1, 1, 1], mean[2, 2, 2] = np.nan, 0.0, -1.5
    image = moments(mean, random.uniform(0.0, 1e-3, (7, 5)))
    back = decode(encode(to_halves(image)), (7, 5))
    np.testing.assert_array_equal(np.moveaxis(back[:3], 0, -1), image.mean.astype(np.float16))
    np.testing.assert_array_equal(back[3], image.sigma.astype(np.float16))


@pytest.mark.parametrize("brightest", [1e-6, 1e-3, DIMMEST, 1.0, 65504.0, 65505.0, 1e9])
def test_no_brightness_loses_the_precision_of_half_floats(brightest: float):
    values = brightest * np.array([1.0, 0.5, 0.01])[None, None, :] * np.ones((2, 2, 1))
    image = moments(values)
    held = to_halves(image)[:3, 0, 0].astype(np.float64) * 2.0 ** exponent_of(image)
    # Ten bits and a hidden one, to a hundredth of the brightest.
    assert np.abs(held / values[0, 0] - 1.0).max() <= 2.0**-11, (brightest, held)
    assert (exponent_of(image) == 0) == (DIMMEST <= brightest <= LARGEST)


def test_an_infinite_value_stays_infinite_beside_finite_ones():
    mean = np.ones((2, 2, 3))
    mean[0, 0] = np.inf
    assert exponent_of(moments(mean)) == 0
    assert np.isinf(to_halves(moments(mean))[:3, 0, 0]).all()


def test_sigma_is_the_standard_error_of_the_mean_luminance():
    images = np.random.default_rng(2).gamma(2.0, 1.0, (9, 4, 5, 3))
    found = moments_of("x", images, 64)
    wanted = luminance(images).std(axis=0, ddof=1) / 3.0
    np.testing.assert_allclose(found.sigma, wanted, rtol=1e-6)
    assert np.isnan(moments_of("x", images[:1], 64).sigma).all()


def test_blocks_are_means_of_their_pixels_at_the_edges_too():
    images = np.random.default_rng(3).uniform(size=(2, 5, 7, 3))
    blocks = block_means(images, 3)
    assert blocks.shape == (2, 2, 3, 3)
    np.testing.assert_allclose(blocks[:, 0, 0], images[:, :3, :3].mean(axis=(1, 2)))
    np.testing.assert_allclose(blocks[:, 1, 2], images[:, 3:, 6:].mean(axis=(1, 2)))
    assert block_means(images, 1) is images


def test_a_panel_larger_than_asked_for_has_the_sigma_of_its_blocks(fabricated_results: Path):
    job = read_jobs(fabricated_results)[0]
    panel = make_panel(job, "path", side=16)
    assert panel is not None and panel.block == 2 and panel.images[0].mean.shape == (16, 16, 3)
    tracer = panel.images[1]
    images = job.seeds("path", tracer.name).images.astype(np.float64)
    small = images.reshape(len(images), 16, 2, 16, 2, 3).mean(axis=(2, 4))
    np.testing.assert_allclose(tracer.mean, small.mean(axis=0), rtol=1e-6)
    wanted = luminance(small).std(axis=0, ddof=1) / np.sqrt(len(images))
    np.testing.assert_allclose(tracer.sigma, wanted, rtol=1e-5, atol=1e-12)


def test_exposures_are_those_that_flip_itself_finds():
    random = np.random.default_rng(4)
    # An odd number of pixels: of an even one FLIP takes one of the two in the middle.
    truth = random.lognormal(-1.0, 1.5, (25, 23, 3)).astype(np.float32)
    _, _, found = flip_evaluator.evaluate(truth, truth, "HDR", applyMagma=False)
    pinned = pin_exposures(truth.astype(np.float64))
    # FLIP finds the root of the tone curve in float32, as a difference of larger numbers.
    assert pinned.start == pytest.approx(found["startExposure"], abs=2e-4)
    assert pinned.stop == pytest.approx(found["stopExposure"], abs=2e-4)
    assert pinned.count == found["numExposures"]


@pytest.mark.parametrize("lit", [0.0, 0.2, 1.0])
def test_exposures_are_finite_where_most_is_black(lit: float):
    truth = np.zeros((10, 10, 3))
    truth.reshape(-1, 3)[: int(100 * lit)] = 0.5
    pinned = pin_exposures(truth)
    assert np.isfinite([pinned.start, pinned.stop]).all() and pinned.count >= 2


def test_the_page_takes_as_many_images_as_allowed_and_names_the_rest(fabricated_results: Path):
    everything = viewer_context(fabricated_results)
    # Two scenes of path with truth and three tracers, and of two models with two.
    assert everything["shown"] == 6 and everything["elsewhere"] == 0
    some = viewer_context(fabricated_results, limit=9)
    panels = catalogue(some)["panels"]
    assert [(p["scene"], p["model"], len(p["images"])) for p in panels] == [
        ("cornell-box", "path", 4),
        ("mirror-glass", "path", 4),
    ]
    assert len(catalogue(some)["elsewhere"]) == some["elsewhere"] == 4


def test_what_must_come_first_is_in_the_page(fabricated_results: Path):
    context = viewer_context(fabricated_results, limit=5, first=[("mirror-glass", "whitted")])
    panels = catalogue(context)["panels"]
    assert [(p["scene"], p["model"]) for p in panels] == [("mirror-glass", "whitted")]


def test_the_page_holds_no_more_bytes_than_allowed(
    fabricated_results: Path, monkeypatch: pytest.MonkeyPatch
):
    one = viewer_context(fabricated_results, limit=4)
    size = len(one["blobs"][0][1])
    monkeypatch.setattr(pack, "INLINE_BYTES", size + 1)
    assert viewer_context(fabricated_results)["shown"] >= 1
    held = sum(len(lines) + 1 for _, lines in viewer_context(fabricated_results)["blobs"])
    assert held <= size + 2
    monkeypatch.setattr(pack, "INLINE_BYTES", 10)
    assert viewer_context(fabricated_results)["shown"] == 0


def test_a_title_cannot_end_the_script_that_holds_it(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("path",), size=8, seeds=2)
    place = folder / "scenes" / "cornell-box" / "scene.json"
    title = "a </script><b> & co"
    place.write_text(json.dumps(json.loads(place.read_text()) | {"title": title}))
    context = viewer_context(folder)
    assert "</" not in context["catalogue"]
    assert catalogue(context)["panels"][0]["title"] == title


def test_full_size_files_hold_means_and_sigmas(fabricated_results: Path, tmp_path: Path):
    context = write_full_size(fabricated_results, tmp_path)
    assert context["blobs"] == [] and context["shown"] == 6
    job = read_jobs(fabricated_results)[0]
    for panel in catalogue(context)["panels"]:
        assert (tmp_path / panel["script"]).read_text().startswith("hasteViewer.register(")
        for image in panel["images"]:
            place = tmp_path / "images" / panel["scene"] / panel["model"] / f"{image['name']}.exr"
            assert place.is_file()
    channels = OpenEXR.File(str(tmp_path / "images/cornell-box/path/embree.exr")).channels()
    images = job.seeds("path", "embree").images.astype(np.float64)
    np.testing.assert_array_equal(channels["RGB"].pixels, images.mean(axis=0).astype(np.float32))
    wanted = luminance(images).std(axis=0, ddof=1) / np.sqrt(len(images))
    np.testing.assert_array_equal(channels["sigma"].pixels, wanted.astype(np.float32))


@pytest.mark.parametrize("name", ["../../etc", "a/b", "a b.c", "ordinary-name_1"])
def test_no_name_leaves_its_folder(name: str):
    assert "/" not in file_name(name) and "." not in file_name(name)


def test_the_worst_place_is_where_an_error_was_planted(fabricate_results: Callable[..., Path]):
    def planted(image: np.ndarray) -> np.ndarray:
        changed = image.copy()
        changed[16:24, 8:16] *= 1.5
        return changed

    folder = fabricate_results(
        scenes=("cornell-box",), models=("path",), changes={"haste-cpu": planted}
    )
    job = read_jobs(folder)[0]
    assert worst_place(job, "path", "haste-cpu") == (12.0, 20.0)
    assert worst_place(job, "path", "embree") is not None
    assert worst_place(job, "path", "haste-cuda") is None


def test_a_pixel_that_is_no_number_is_the_worst_place(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("path",), seeds=3)
    path = folder / "scenes/cornell-box/seeds/path/embree/seed_001.npy"
    image = np.load(path)
    image[30, 2] = np.nan
    np.save(path, image)
    assert worst_place(read_jobs(folder)[0], "path", "embree") == (4.0, 28.0)


def test_a_link_names_its_view():
    assert link_of("skull", "path", "embree") == "#view=skull/path/embree&mode=relative"
    link = link_of("a b/c", "path", "x", mode="p", place=(12.0, 20.5), zoom=4.0)
    assert link == "#view=a%20b%2Fc/path/x&mode=p&x=12&y=20.5&zoom=4"


def test_the_page_has_every_script_and_none_is_long():
    files = sorted(HERE.glob("*.js"))
    assert sorted(SCRIPTS) == [file.name for file in files]
    for file in files:
        lines = file.read_text().splitlines()
        assert len(lines) < LONGEST_FILE, file.name
        assert max(map(len, lines)) <= 100, file.name
