"""Views of the viewer: links to them, and what mouse, fingers and paper make of them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_page import (
    WITH_SOFTWARE_WEBGL,
    WITHOUT_WEBGL,
    change,
    read_cells,
    stage_pixels,
    wait_until_ready,
    write_page,
)

from harness.viewer.links import link_of
from harness.viewer.pack import viewer_context, write_full_size

SIZE = 32
STATE = """() => {
  const { panel, a, b, mode, x, y, zoom, exposure, finer, layout, split, shown, cursor } =
    hasteViewer.app.state;
  return {
    panel: panel.key, a, b, mode, x, y, zoom, exposure, finer, layout, split, shown, cursor,
  };
}"""
FULL_LINK = (
    "#view=mirror-glass/haste/embree&mode=relative&b=haste-cpu&x=20.5&y=12.25&zoom=3"
    "&exposure=-1.5&finer=2&layout=split&split=0.3&at=19,11"
)


@pytest.fixture(scope="module")
def page_file(fabricated_results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    context = viewer_context(fabricated_results, limit=12, first=[("mirror-glass", "haste")])
    return write_page(context, tmp_path_factory.mktemp("views") / "report.html")


@pytest.fixture
def view(page_file: Path, open_page: Callable[..., Any]) -> Callable[..., Any]:
    """Open the page at a link, in a small window, and wait for its picture."""

    def open_view(hash: str = "", **how: Any) -> Any:  # noqa: A002 - as open_page has it
        how = {"width": 700, "script": WITHOUT_WEBGL, **how}
        opened = open_page(page_file, hash=hash, **how)
        wait_until_ready(opened.page)
        return opened

    return open_view


def state(page: Any) -> dict[str, Any]:
    return page.evaluate(STATE)


def settled_hash(page: Any) -> str:
    """The address after it has taken up the view."""
    page.wait_for_timeout(600)
    return page.evaluate("location.hash")


def stage_box(page: Any) -> dict[str, float]:
    page.locator(".viewer-stage").scroll_into_view_if_needed()
    return page.locator(".viewer-stage").bounding_box()


def test_a_link_restores_every_part_of_its_view(view: Callable[..., Any]):
    opened = view(FULL_LINK)
    assert state(opened.page) == {
        "panel": "mirror-glass/haste",
        "a": "embree",
        "b": "haste-cpu",
        "mode": "relative",
        "x": 20.5,
        "y": 12.25,
        "zoom": 3,
        "exposure": -1.5,
        "finer": 2,
        "layout": "split",
        "split": 0.3,
        "shown": 0,
        "cursor": {"x": 19, "y": 11},
    }
    assert opened.page.locator(".viewer-place").inner_text() == "Pixel x = 19, y = 11"
    stage = stage_box(opened.page)
    assert stage["y"] >= 0 and stage["y"] + stage["height"] <= 900, stage


def test_a_view_is_the_same_after_a_way_through_its_link(view: Callable[..., Any]):
    first = view().page
    wanted = {"mode": "squared", "x": 9, "y": 21.5, "zoom": 2.5, "exposure": 1, "layout": "flip"}
    change(first, wanted | {"shown": 1, "cursor": {"x": 8, "y": 20}})
    second = view(settled_hash(first)).page
    assert state(second) == state(first)
    assert read_cells(second) == read_cells(first)
    np.testing.assert_array_equal(stage_pixels(second), stage_pixels(first))
    other = view(settled_hash(first).replace("zoom=2.5", "zoom=2.4")).page
    assert not np.array_equal(stage_pixels(other), stage_pixels(first))


def test_links_of_the_report_are_followed_again_and_again(view: Callable[..., Any]):
    page = view().page
    link = link_of("mirror-glass", "haste", "embree", place=(12.0, 20.0), zoom=4.0)
    page.evaluate("(link) => { document.getElementById('before').href = link; }", link)
    for _ in range(2):
        page.evaluate("window.scrollTo(0, 0)")
        page.locator("#before").click()
        page.wait_for_function("hasteViewer.app.state.panel.key === 'mirror-glass/haste'")
        page.wait_for_function("window.scrollY > 500")
        found = state(page)
        assert (found["x"], found["y"], found["zoom"]) == (12, 20, 4)
        assert (found["mode"], found["b"]) == ("relative", "truth")
        assert found["cursor"] == {"x": 12, "y": 20}
    # Not what follows the text alone: another link is another view.
    page.evaluate("location.hash = '#view=cornell-box/path/haste-cpu'")
    page.wait_for_function("hasteViewer.app.state.panel.key === 'cornell-box/path'")
    page.evaluate("location.hash = '#after'")
    assert state(page)["panel"] == "cornell-box/path"


@pytest.mark.parametrize(
    ("link", "says"),
    [
        ("#view=cornell-box/whitted/embree", "cornell-box in whitted is in report.zip"),
        ("#view=nowhere/path/embree", "nowhere in path is not here"),
        ("#view=cornell-box/path/nobody", "nobody has no image of cornell-box in path"),
        ("#view=cornell-box/path/embree&b=no%20one", "no one has no image"),
        ("#view=%E0%A4%A", "is not here"),
    ],
)
def test_a_link_to_what_is_not_there_says_so(view: Callable[..., Any], link: str, says: str):
    opened = view(link)
    assert says in opened.page.locator(".viewer-message").inner_text()
    assert opened.errors == []


def test_impossible_numbers_of_a_link_become_possible(view: Callable[..., Any]):
    opened = view("#view=cornell-box/path/embree&x=-5&y=NaN&zoom=1e9&exposure=99&split=7&at=900,3")
    found = state(opened.page)
    assert (found["x"], found["y"], found["zoom"]) == (0, SIZE / 2, 64)
    assert (found["exposure"], found["split"], found["layout"]) == (10, 1, "split")
    assert found["cursor"] == {"x": SIZE - 1, "y": 3}
    assert opened.errors == []


def test_panes_are_panned_and_zoomed_together(view: Callable[..., Any]):
    page = view("#view=cornell-box/path/embree&b=embree&mode=image").page
    box = stage_box(page)
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 150, box["y"] + 80, steps=4)
    page.mouse.up()
    moved = state(page)
    assert moved["x"] < SIZE / 2 and moved["y"] > SIZE / 2
    page.mouse.wheel(0, -300)
    page.wait_for_function("hasteViewer.app.state.zoom > 1.9")
    pixels = stage_pixels(page)
    half = (pixels.shape[1] - 6) // 2
    np.testing.assert_array_equal(pixels[:, :half], pixels[:, -half:])
    change(page, {"b": "truth"})
    pixels = stage_pixels(page)
    assert not np.array_equal(pixels[:, :half], pixels[:, -half:])


def test_what_is_under_the_mouse_stays_there_while_the_wheel_zooms(view: Callable[..., Any]):
    page = view("#view=cornell-box/path/embree&layout=flip").page
    box = stage_box(page)
    page.locator(".viewer-stage").focus()
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.4 * box["height"])
    page.wait_for_function("hasteViewer.app.state.cursor !== null")
    before = state(page)["cursor"]
    for _ in range(4):
        page.mouse.wheel(0, -100)
    page.wait_for_function("hasteViewer.app.state.zoom > 2.4")
    page.mouse.move(box["x"] + 0.7 * box["width"] + 0.2, box["y"] + 0.4 * box["height"])
    assert state(page)["cursor"] == before


def test_the_wheel_scrolls_the_page_until_the_stage_has_the_focus(view: Callable[..., Any]):
    page = view("#view=cornell-box/path/embree").page
    box = stage_box(page)
    page.mouse.move(box["x"] + 50, box["y"] + 50)
    before = page.evaluate("scrollY")
    page.mouse.wheel(0, 120)
    page.wait_for_function("(before) => scrollY > before", arg=before)
    assert state(page)["zoom"] == 1


def test_the_divider_follows_the_mouse(view: Callable[..., Any]):
    page = view("#view=cornell-box/path/embree&mode=relative&split=0.5").page
    box = stage_box(page)
    middle = box["x"] + 0.5 * box["width"]
    page.mouse.move(middle, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(middle - 0.25 * box["width"], box["y"] + 60, steps=3)
    page.mouse.up()
    found = state(page)
    assert found["split"] == pytest.approx(0.25, abs=0.01) and found["x"] == SIZE / 2


def test_two_fingers_zoom_and_one_chooses_a_pixel(view: Callable[..., Any]):
    page = view("#view=cornell-box/path/embree&layout=flip", width=400, has_touch=True).page
    box = stage_box(page)
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.touchscreen.tap(x - 20, y - 20)
    page.wait_for_function("hasteViewer.app.state.cursor !== null")
    session = page.context.new_cdp_session(page)

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": px, "y": py, "id": k} for k, (px, py) in enumerate(places)]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", (x - 20, y))
    touch("touchStart", (x - 20, y), (x + 20, y))
    for step in range(1, 6):
        touch("touchMove", (x - 20 - 8 * step, y), (x + 20 + 8 * step, y))
    touch("touchEnd")
    page.wait_for_function("hasteViewer.app.state.zoom > 2")
    found = state(page)
    # Fingers that move apart evenly leave what is between them in its place.
    assert found["zoom"] == pytest.approx(3.0, rel=0.1)
    assert found["x"] == pytest.approx(SIZE / 2, abs=1.0)


def test_a_lost_webgl_context_is_replaced_by_the_canvas(
    page_file: Path, open_page: Callable[..., Any]
):
    link = "#view=cornell-box/path/embree&mode=relative"
    page = open_page(page_file, hash=link, width=700, script=WITH_SOFTWARE_WEBGL).page
    wait_until_ready(page)
    before = stage_pixels(page).astype(int)
    page.evaluate(
        """() => document.querySelector(".viewer-stage canvas").getContext("webgl2")
          .getExtension("WEBGL_lose_context").loseContext()"""
    )
    page.wait_for_function("hasteViewer.app.stage.painter === 'canvas'")
    assert np.abs(stage_pixels(page).astype(int) - before).max() <= 1


def test_full_size_images_are_read_from_the_disk(
    fabricated_results: Path, tmp_path: Path, open_page: Callable[..., Any]
):
    file = write_page(write_full_size(fabricated_results, tmp_path), tmp_path / "report.html")
    opened = open_page(file, hash="#view=cornell-box/path/embree&at=3,4", script=WITHOUT_WEBGL)
    wait_until_ready(opened.page)
    inline = write_page(viewer_context(fabricated_results), tmp_path / "inline" / "report.html")
    other = open_page(inline, hash="#view=cornell-box/path/embree&at=3,4", script=WITHOUT_WEBGL)
    wait_until_ready(other.page)
    assert read_cells(opened.page) == read_cells(other.page)
    assert all(address.startswith("file:") for address in opened.requests)
    assert opened.errors == [] and other.errors == []
    # A script that is not there is named, and nothing else breaks.
    (tmp_path / "viewer" / "mirror-glass.path.js").unlink()
    opened.page.locator("[name=viewer-scene]").select_option("mirror-glass")
    opened.page.wait_for_function(
        "document.querySelector('.viewer-message').textContent.includes('mirror-glass.path.js')"
    )


@pytest.mark.parametrize("width", [400, 1440])
@pytest.mark.parametrize("layout", ["side", "split", "flip"])
def test_nothing_is_wider_than_the_window(view: Callable[..., Any], width: int, layout: str):
    page = view(f"#view=cornell-box/path/embree&mode=p&layout={layout}&at=3,3", width=width).page
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    stage = page.locator(".viewer-stage").bounding_box()
    assert stage["width"] > 0.75 * min(width, 1080)


def test_paper_shows_the_pictures_and_no_controls(view: Callable[..., Any]):
    page = view("#view=cornell-box/path/embree").page
    assert page.locator(".viewer-controls").is_visible()
    page.emulate_media(media="print")
    assert not page.locator(".viewer-controls").is_visible()
    assert page.locator(".viewer-stage canvas").is_visible()
    assert page.locator(".viewer-caption").inner_text() == "Cornell box, path"


def test_dark_pages_have_a_dark_viewer(view: Callable[..., Any]):
    colours = [
        view(dark=dark).page.evaluate(
            "getComputedStyle(document.querySelector('[name=viewer-scene]')).backgroundColor"
        )
        for dark in (False, True)
    ]
    light, dark = (sum(map(int, colour[4:-1].split(","))) for colour in colours)
    assert dark < 200 and light > 600, colours
