"""The viewer's pixels in Chromium: read-out, errors, colours, with WebGL and without."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import flip_evaluator
import numpy as np
import OpenEXR
import pytest
from viewer_page import (
    WITH_SOFTWARE_WEBGL,
    WITHOUT_WEBGL,
    as_number,
    change,
    map_values,
    stage_pixels,
    wait_until_ready,
    write_page,
)

from harness.report.picture import colour_errors, encode_srgb
from harness.statistics.metrics import LUMINANCE, make_truth
from harness.statistics.tiles import welch_from_moments
from harness.tables.read import read_jobs
from harness.viewer.pack import viewer_context, write_full_size
from harness.viewer.panels import make_panel

MODES = ("image", "relative", "squared", "deviation", "p", "flip")
SIZE = 16
ROUNDING = 2.0**-10
"""Relative difference between equal values that two roundings to half floats may leave."""
FLOAT32 = 2.0**-23
"""Of maps, which are kept in single precision."""


@pytest.fixture(scope="module")
def folder(
    fabricate_once: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """A page of full-size images beside their EXR files, and the results that it came from."""
    results = fabricate_once(
        scenes=("cornell-box",),
        models=("path", "whitted"),
        size=SIZE,
        seeds=16,
        changes={"haste-cpu": lambda image: 1.05 * image},
    )
    # One pixel of one image is no number.
    place = results / "scenes/cornell-box/seeds/path/embree/seed_003.npy"
    image = np.load(place)
    image[7, 9] = [np.nan, 1.0, 1.0]
    np.save(place, image)
    out = tmp_path_factory.mktemp("page")
    page = write_page(write_full_size(results, out), out / "report.html")
    inline = write_page(viewer_context(results), out / "inline" / "report.html")
    return {"results": results, "page": page, "inline": inline, "images": out / "images"}


@pytest.fixture
def show(folder: dict[str, Any], open_page: Callable[..., Any]) -> Callable[..., Any]:
    """Open the page at a link in a small window, and wait for its picture."""

    def show_link(
        link: str = "", *, kind: str = "page", script: str = WITHOUT_WEBGL, width: int = 480
    ) -> Any:
        opened = open_page(folder[kind], hash=link, script=script, width=width, height=320)
        wait_until_ready(opened.page)
        return opened

    return show_link


def half(folder: dict[str, Any], model: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Mean [h, w, 3] and sigma [h, w] of an EXR file, rounded to half floats."""
    path = folder["images"] / "cornell-box" / model / f"{name}.exr"
    channels = OpenEXR.File(str(path)).channels()
    return channels["RGB"].pixels.astype(np.float16), channels["sigma"].pixels.astype(np.float16)


def read_all_pixels(page: Any) -> list[dict[str, str]]:
    """Texts of the read-out of every pixel, as the cursor goes over them."""
    return page.evaluate(
        """async () => {
          const { app } = hasteViewer;
          const { panel } = app.state;
          const cells = [...document.querySelectorAll("#viewer [data-cell]")];
          const texts = [];
          for (let y = 0; y < panel.rows; y++) {
            for (let x = 0; x < panel.columns; x++) {
              await app.change({ cursor: { x, y } });
              texts.push(Object.fromEntries(cells.map((c) => [c.dataset.cell, c.textContent])));
            }
          }
          return texts;
        }"""
    )


@pytest.mark.parametrize("kind", ["page", "inline"])
def test_the_read_out_is_the_exr_rounded_to_half(
    folder: dict[str, Any], show: Callable[..., Any], kind: str
):
    opened = show("#view=cornell-box/path/embree", kind=kind)
    texts = read_all_pixels(opened.page)
    for letter, name in (("a", "embree"), ("b", "truth")):
        mean, sigma = half(folder, "path", name)
        cells = ("red", "green", "blue", "sigma")
        read = np.array([[as_number(row[f"{letter}-{cell}"]) for cell in cells] for row in texts])
        wanted = np.concatenate([mean, sigma[..., None]], axis=-1).reshape(-1, 4)
        np.testing.assert_array_equal(read.astype(np.float16), wanted)
        # The next half float would have been noticed.
        nudged = np.nextafter(wanted[0, 0], np.float16(np.inf))
        assert np.float16(read[0, 0]) != nudged
    assert opened.errors == []
    assert all(address.startswith("file:") for address in opened.requests), opened.requests


def in_double(image: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return image[0].astype(np.float64), image[1].astype(np.float64)


def expected(folder: dict[str, Any], model: str, a: str, b: str) -> dict[str, np.ndarray]:
    """Maps of the modes by NumPy and the project's own statistics, from the half floats."""
    job = read_jobs(folder["results"])[0]
    panel = make_panel(job, model)
    assert panel is not None
    counts = {image.name: (image.count, image.spp) for image in panel.images}
    (mean_a, sigma_a), (mean_b, sigma_b) = (in_double(half(folder, model, name)) for name in (a, b))
    epsilon = make_truth(job.truth(model).batches).epsilon
    light_a, light_b = mean_a @ LUMINANCE, mean_b @ LUMINANCE
    sides = [
        (light, sigma**2 * counts[name][0], counts[name][0])
        for light, sigma, name in ((light_a, sigma_a, a), (light_b, sigma_b, b))
    ]
    count, spp = counts[a]
    with np.errstate(divide="ignore"):
        return {
            "relative": (light_a - light_b) / np.sqrt(light_b**2 + epsilon),
            "squared": np.log10(((mean_a - mean_b) ** 2 / (mean_b**2 + epsilon)).mean(axis=-1)),
            "deviation": np.log10(sigma_a * np.sqrt(count * spp)),
            "p": -np.log10(welch_from_moments(*sides, rounding=ROUNDING)),
        }


@pytest.mark.parametrize("model", ["path", "whitted"])
@pytest.mark.parametrize(("a", "b"), [("haste-cpu", "truth"), ("embree", "haste-cpu")])
def test_errors_are_those_of_numpy(
    folder: dict[str, Any], show: Callable[..., Any], model: str, a: str, b: str
):
    opened = show(f"#view=cornell-box/{model}/{a}")
    for mode, wanted in expected(folder, model, a, b).items():
        values = map_values(opened.page, mode, a, b)
        # Student's tail is good to 1e-12, and everything is rounded to single precision once.
        # A difference of luminances loses the digits in which they agree: 2^-52 of them is left.
        message = f"{mode} of {a} against {b} in {model}"
        np.testing.assert_allclose(
            values, wanted, rtol=2 * FLOAT32, atol=1e-12, err_msg=message, equal_nan=True
        )
        # The same of the images the other way round is told apart.
        swapped = expected(folder, model, b, a)[mode]
        if mode != "p":
            assert not np.allclose(values, swapped, rtol=1e-4, equal_nan=True), message


def test_half_floats_alone_are_no_evidence(folder: dict[str, Any], show: Callable[..., Any]):
    """Where there is no noise, images that differ by a rounding have p = 1, not p = 0."""
    opened = show("#view=cornell-box/whitted/embree")
    mean, sigma = half(folder, "whitted", "embree")
    quiet = (sigma == 0) & (mean.max(axis=-1) > 0)
    assert quiet.sum() > 20
    assert (map_values(opened.page, "p", "embree", "truth")[quiet] == 0.0).all()
    # haste-cpu is 5 % too bright everywhere.
    assert np.isinf(map_values(opened.page, "p", "haste-cpu", "truth")[quiet]).all()


def test_flip_is_that_of_its_authors(folder: dict[str, Any], show: Callable[..., Any]):
    opened = show("#view=cornell-box/path/haste-cpu&mode=flip")
    panel = make_panel(read_jobs(folder["results"])[0], "path")
    assert panel is not None
    pinned = {
        "startExposure": panel.flip.start,
        "stopExposure": panel.flip.stop,
        "numExposures": panel.flip.count,
    }
    test, reference = (np.float32(half(folder, "path", name)[0]) for name in ("haste-cpu", "truth"))
    wanted, _, _ = flip_evaluator.evaluate(
        reference, test, "HDR", applyMagma=False, parameters=pinned
    )
    values = map_values(opened.page, "flip", "haste-cpu", "truth")
    # Theirs is in float32: sums of 21^2 weights, then powers below one, which widen small errors.
    np.testing.assert_allclose(values, wanted.reshape(values.shape), atol=1e-4)
    assert values.max() > 0.01
    shifted, _, _ = flip_evaluator.evaluate(
        *(reference, test, "HDR"),
        applyMagma=False,
        parameters=pinned | {"stopExposure": panel.flip.stop - 1.0},
    )
    assert np.abs(values - shifted.reshape(values.shape)).max() > 1e-3


def test_ldr_flip_is_that_of_its_authors(show: Callable[..., Any]):
    opened = show()
    random = np.random.default_rng(5)
    reference = random.uniform(size=(20, 31, 3)).astype(np.float32)
    reference[5:12, 8:20] = [0.1, 0.6, 0.2]
    test = np.clip(reference + random.normal(0.0, 0.1, reference.shape), 0, 1).astype(np.float32)
    values = opened.page.evaluate(
        """([test, reference, width, height]) =>
          Array.from(hasteViewer.flip.ldr(
            test.map((plane) => Float64Array.from(plane)),
            reference.map((plane) => Float64Array.from(plane)), width, height))""",
        [
            *([image[..., c].ravel().tolist() for c in range(3)] for image in (test, reference)),
            *(31, 20),
        ],
    )
    # Pixels a degree of the usual distance and monitor, as FLIP has them.
    wanted, _, _ = flip_evaluator.evaluate(
        reference, test, "LDR", inputsRGB=False, applyMagma=False
    )
    np.testing.assert_allclose(np.reshape(values, (20, 31)), wanted.reshape(20, 31), atol=1e-4)


def centres(frame: tuple[float, float, float], columns: int, rows: int) -> tuple[Any, Any]:
    """Places on the stage of the centres of an image's pixels, from corner and scale."""
    left, top, scale = frame
    x = np.floor(left + (np.arange(columns) + 0.5) * scale).astype(int)
    y = np.floor(top + (np.arange(rows) + 0.5) * scale).astype(int)
    return np.ix_(y, x)


@pytest.mark.parametrize("script", [WITH_SOFTWARE_WEBGL, WITHOUT_WEBGL], ids=["WebGL", "canvas"])
def test_the_stage_shows_what_the_report_shows(
    folder: dict[str, Any], show: Callable[..., Any], script: str
):
    link = "#view=cornell-box/path/haste-cpu&layout=flip&exposure=1"
    opened = show(link, script=script)
    panel = make_panel(read_jobs(folder["results"])[0], "path")
    assert panel is not None
    height, width = stage_pixels(opened.page).shape[:2]
    scale = min(width / SIZE, height / SIZE)
    frame = ((width - scale * SIZE) / 2, (height - scale * SIZE) / 2, scale)
    mean = half(folder, "path", "haste-cpu")[0].astype(np.float64)
    shown = stage_pixels(opened.page)[centres(frame, SIZE, SIZE)]
    wanted = encode_srgb(2.0 * panel.exposure * mean)
    assert np.abs(shown[..., :3].astype(int) - wanted).max() <= 1
    assert (shown[..., 3] == 255).all()
    darker = encode_srgb(1.9 * panel.exposure * mean)
    assert np.abs(shown[..., :3].astype(int) - darker).max() > 1
    change(opened.page, {"mode": "relative", "shown": 1, "exposure": 0})
    shown = stage_pixels(opened.page)[centres(frame, SIZE, SIZE)][..., :3].astype(int)
    relative = expected(folder, "path", "haste-cpu", "truth")["relative"]
    # Both maps are tables: 256 colours in between are a level apart at most.
    assert np.abs(shown - colour_errors(relative, panel.limits.relative)).max() <= 2
    change(opened.page, {"finer": 1})
    shown = stage_pixels(opened.page)[centres(frame, SIZE, SIZE)][..., :3].astype(int)
    assert np.abs(shown - colour_errors(relative, panel.limits.relative / 2.0)).max() <= 2
    assert np.abs(shown - colour_errors(relative, panel.limits.relative)).max() > 2


@pytest.mark.parametrize("width", [400, 700], ids=["stacked", "side by side"])
def test_both_painters_paint_the_same(show: Callable[..., Any], width: int):
    link = "#view=cornell-box/path/embree&x=7.3&y=9.1&zoom=1.7&exposure=0.5"
    pages = []
    for script, name in ((WITH_SOFTWARE_WEBGL, "WebGL"), (WITHOUT_WEBGL, "canvas")):
        opened = show(link, script=script, width=width)
        assert opened.page.evaluate("hasteViewer.app.stage.painter") == name
        pages.append(opened.page)
    for mode in MODES:
        for layout in ("side", "split", "flip"):
            for page in pages:
                change(page, {"mode": mode, "layout": layout, "shown": 1, "split": 0.37})
            first, second = (stage_pixels(page).astype(int) for page in pages)
            assert first.shape == second.shape
            apart = np.abs(first - second).max()
            assert apart <= 1, f"{mode}, {layout}: {apart} levels apart"
    # An eighth of a stop is seen.
    change(pages[0], {"mode": "image", "exposure": 0.625})
    change(pages[1], {"mode": "image", "exposure": 0.5})
    first, second = (stage_pixels(page).astype(int) for page in pages)
    assert np.abs(first - second).max() > 1


@pytest.mark.parametrize("mode", ["image", "relative", "squared", "deviation", "p"])
def test_the_worst_pixel_is_found(folder: dict[str, Any], show: Callable[..., Any], mode: str):
    opened = show(f"#view=cornell-box/path/haste-cpu&mode={mode}&zoom=3")
    wanted = expected(folder, "path", "haste-cpu", "truth")["relative" if mode == "image" else mode]
    opened.page.locator("[data-action=worst]").click()
    opened.page.wait_for_function("hasteViewer.app.state.cursor !== null")
    found = opened.page.evaluate("hasteViewer.app.state")
    x, y = found["cursor"]["x"], found["cursor"]["y"]
    worst = np.abs(wanted).max() if mode in {"image", "relative"} else wanted.max()
    assert abs(wanted[y, x]) == pytest.approx(abs(worst), rel=1e-6)
    assert (found["x"], found["y"]) == (x + 0.5, y + 0.5)


def test_what_is_no_number_is_worse_than_any(show: Callable[..., Any]):
    opened = show("#view=cornell-box/path/embree&mode=squared")
    opened.page.locator(".viewer-stage").focus()
    opened.page.keyboard.press("w")
    opened.page.wait_for_function("hasteViewer.app.state.cursor !== null")
    assert opened.page.evaluate("hasteViewer.app.state.cursor") == {"x": 9, "y": 7}


@pytest.mark.parametrize("script", [WITH_SOFTWARE_WEBGL, WITHOUT_WEBGL], ids=["WebGL", "canvas"])
def test_what_is_no_number_is_magenta(show: Callable[..., Any], script: str):
    opened = show("#view=cornell-box/path/embree&layout=flip&zoom=16", script=script)

    def middle(mode: str, x: float) -> list[int]:
        shown = 0 if mode in {"image", "deviation"} else 1
        change(opened.page, {"mode": mode, "shown": shown, "x": x, "y": 7.5})
        pixels = stage_pixels(opened.page)
        return pixels[pixels.shape[0] // 2, pixels.shape[1] // 2].tolist()

    for mode in MODES:
        # A p-value is known where a number is not: it is 0, as in the tile test.
        assert (middle(mode, 9.5) == [255, 0, 255, 255]) == (mode != "p"), mode
        assert middle(mode, 4.5) != [255, 0, 255, 255], mode
