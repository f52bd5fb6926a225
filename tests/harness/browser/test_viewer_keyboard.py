"""The viewer by keyboard alone."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser
from viewer_page import WITHOUT_WEBGL, change, wait_until_ready, write_page

from harness.viewer.pack import viewer_context

START = "#view=cornell-box/path/embree&mode=relative&layout=split&zoom=2&at=10,10"
BEGIN = {
    "a": "embree",
    "b": "truth",
    "mode": "relative",
    "layout": "split",
    "split": 0.5,
    "shown": 0,
    "exposure": 0,
    "finer": 0,
    "zoom": 2,
    "x": 16,
    "y": 16,
    "cursor": {"x": 10, "y": 10},
}
"""The same as a state."""
REACHED = """() => {
  const { activeElement } = document;
  const style = getComputedStyle(activeElement);
  const around = activeElement.closest("label");
  const outlined = (element) => element && getComputedStyle(element).outlineStyle !== "none";
  return {
    inside: Boolean(activeElement.closest("#viewer")),
    name: activeElement.name || activeElement.dataset.action || activeElement.className
      || activeElement.tagName.toLowerCase(),
    seen: outlined(activeElement) || outlined(around),
  };
}"""
CONTROLS = """() => [...document.querySelectorAll(
    "#viewer :is(select, input, button, summary, [tabindex])")]
  .filter((one) => one.checkVisibility() && !one.closest("dialog"))
  .map((one) => one.name || one.dataset.action || one.className || one.tagName.toLowerCase())"""
NAMES = """() => [...document.querySelectorAll(
    "#viewer :is(select, input, button, [role=application], dialog)")]
  .filter((one) => !(one.getAttribute("aria-label") || one.labels?.length
    || one.textContent.trim()))
  .map((one) => one.outerHTML)"""


@pytest.fixture(scope="module")
def page_file(fabricated_results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    context = viewer_context(fabricated_results)
    return write_page(context, tmp_path_factory.mktemp("keyboard") / "report.html")


@pytest.fixture
def page(page_file: Path, open_page: Callable[..., Any]) -> Any:
    opened = open_page(page_file, hash=START, width=700, script=WITHOUT_WEBGL)
    wait_until_ready(opened.page)
    return opened.page


@pytest.fixture(scope="module")
def shared_page(chromium: Browser, page_file: Path) -> Iterator[Any]:
    """One page for tests that begin by going to BEGIN."""
    context = chromium.new_context(viewport={"width": 700, "height": 600})
    page = context.new_page()
    page.add_init_script(WITHOUT_WEBGL)
    page.goto(page_file.as_uri() + START)
    wait_until_ready(page)
    yield page
    context.close()


def tab_through(page: Any, steps: int = 60) -> list[dict[str, Any]]:
    """What has the focus after each press of the tabulator, from before the viewer to after it."""
    page.locator("#before").focus()
    stops = []
    for _ in range(steps):
        page.keyboard.press("Tab")
        stops.append(page.evaluate(REACHED))
        if not stops[-1]["inside"]:
            return stops[:-1]
    raise AssertionError(f"no way out of the viewer in {steps} steps: {stops}")


def value(page: Any, name: str) -> Any:
    return page.evaluate("(name) => hasteViewer.app.state[name]", name)


def test_the_tabulator_reaches_every_control_and_leaves(page: Any):
    stops = tab_through(page)
    assert {stop["name"] for stop in stops} == set(page.evaluate(CONTROLS))
    assert all(stop["seen"] for stop in stops), [s["name"] for s in stops if not s["seen"]]
    # One control taken out of the order is missed.
    page.evaluate("document.querySelector('[data-action=fit]').tabIndex = -1")
    missed = set(page.evaluate(CONTROLS)) - {stop["name"] for stop in tab_through(page)}
    assert missed == {"fit"}


def test_every_control_has_a_name(page: Any):
    assert page.evaluate(NAMES) == []
    page.evaluate("document.querySelector('[data-action=flip]').textContent = ''")
    assert len(page.evaluate(NAMES)) == 1


@pytest.mark.parametrize(
    ("key", "name", "wanted"),
    [
        ("1", "mode", "image"),
        ("3", "mode", "squared"),
        ("4", "mode", "deviation"),
        ("5", "mode", "p"),
        ("6", "mode", "flip"),
        ("v", "layout", "flip"),
        ("f", "shown", 1),
        ("a", "a", "mitsuba-llvm"),
        ("Shift+A", "a", "haste-cpu"),
        ("b", "b", "haste-cpu"),
        ("e", "exposure", 0.5),
        ("Shift+E", "exposure", -0.5),
        ("s", "finer", 0.5),
        ("Shift+S", "finer", -0.5),
        ("]", "split", 0.55),
        ("[", "split", 0.45),
        ("+", "zoom", 2**1.5),
        ("-", "zoom", 2**0.5),
        ("c", "x", 10.5),
        ("ArrowLeft", "cursor", {"x": 9, "y": 10}),
        ("ArrowRight", "cursor", {"x": 11, "y": 10}),
        ("ArrowUp", "cursor", {"x": 10, "y": 9}),
        ("Shift+ArrowDown", "cursor", {"x": 10, "y": 18}),
        (" ", "held", False),
    ],
)
def test_a_key_does_what_the_list_says(shared_page: Any, key: str, name: str, wanted: object):
    change(shared_page, BEGIN)
    shared_page.locator(".viewer-stage").focus()
    shared_page.keyboard.press(key)
    found = value(shared_page, name)
    assert found == (pytest.approx(wanted) if isinstance(wanted, float) else wanted)


def test_keys_of_scene_and_model_go_round(page: Any):
    page.locator(".viewer-stage").focus()
    seen = []
    for key in ("n", "n", "m", "m", "Shift+M"):
        page.keyboard.press(key)
        seen.append(page.evaluate("hasteViewer.app.state.panel.key"))
    assert seen == [
        "mirror-glass/path",
        "cornell-box/path",
        "cornell-box/haste",
        "cornell-box/whitted",
        "cornell-box/haste",
    ]


def test_space_shows_the_other_side_while_it_is_held(page: Any):
    page.locator(".viewer-stage").focus()
    page.keyboard.down(" ")
    assert value(page, "held") is True
    page.keyboard.up(" ")
    assert value(page, "held") is False


def test_the_view_follows_a_cursor_that_would_leave_it(page: Any):
    page.evaluate("hasteViewer.app.change({ zoom: 8, x: 10, y: 10 })")
    page.locator(".viewer-stage").focus()
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    # Told last, and of the last pixel alone where keys come fast.
    page.wait_for_function(
        "document.querySelector('.viewer-status').textContent.startsWith('Pixel x = 22,')"
    )
    assert value(page, "cursor") == {"x": 22, "y": 10}
    assert abs(value(page, "x") - 22.5) < 3
    told = page.locator(".viewer-status").text_content()
    assert told.startswith("Pixel x = 22, y = 10: luminance of A "), told


def test_the_list_of_keys_opens_and_closes_and_gives_the_focus_back(page: Any):
    page.locator(".viewer-stage").focus()
    page.keyboard.press("?")
    assert page.locator(".viewer-help").is_visible()
    listed = page.locator(".viewer-help dt").all_inner_texts()
    for key in ("n", "m", "a", "b", "1", "6", "v", "f", "[", "]", "+", "-", "0", "c", "e", "l"):
        assert key in listed, (key, listed)
    page.keyboard.press("3")
    assert value(page, "mode") == "relative", "keys must rest while the list is read"
    page.keyboard.press("Escape")
    assert not page.locator(".viewer-help").is_visible()
    assert page.evaluate("document.activeElement.className").startswith("viewer-stage")


def test_keys_do_nothing_outside_of_the_viewer_and_in_its_choices(page: Any):
    page.locator("#before").focus()
    page.keyboard.press("3")
    assert value(page, "mode") == "relative"
    page.locator("[name=viewer-scene]").focus()
    page.keyboard.press("3")
    assert value(page, "mode") == "relative"
    page.locator(".viewer-stage").focus()
    page.keyboard.press("Control+3")
    assert value(page, "mode") == "relative"


def test_a_link_is_copied_into_the_address(page: Any):
    page.locator(".viewer-stage").focus()
    page.keyboard.press("3")
    page.keyboard.press("2")
    page.keyboard.press("l")
    page.wait_for_function("document.querySelector('.viewer-message').textContent !== ''")
    assert "mode=relative" in page.evaluate("location.hash")
