"""The report as a reader meets it: opened from a disk in Chromium, looked at, typed at, printed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from planted_page import FAILURES, TILE_AT
from playwright.sync_api import Page
from playwright.sync_api import TimeoutError as PageTimeoutError

from harness.statistics.tiles import TILE

WIDTHS = (1440, 400)
KEYS_AT_MOST = 4000
"""Presses of the tabulator after which a page has no end."""

REACHABLE = """() => {
  const shown = (e) => e.checkVisibility({ visibilityProperty: true });
  const kinds = 'a[href], button, input, select, summary, [tabindex]';
  const found = [...document.querySelectorAll(kinds)];
  return found.filter((e) => shown(e) && e.tabIndex >= 0 && !e.disabled)
    .filter((e) => e.type !== 'radio' || e.checked).map((e) => {
      e.dataset.reach ??= String(++window.reached);
      return e.dataset.reach;
    });
}"""
CONTRAST = """() => {
  const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  const rgba = (text) => {
    canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = text; canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    return [r / 255, g / 255, b / 255, a / 255];
  };
  const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const behind = (e) => {
    for (; e; e = e.parentElement) {
      const colour = rgba(getComputedStyle(e).backgroundColor);
      if (colour[3] === 1) return colour;
    }
    return [1, 1, 1, 1];
  };
  const poor = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const e = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || e.closest('svg, script, style, .viewer-stage, .unseen')
        || !e.checkVisibility({ visibilityProperty: true })) continue;
    const style = getComputedStyle(e);
    const [front, back] = [light(rgba(style.color)), light(behind(e))];
    const ratio = (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05);
    const large = parseFloat(style.fontSize) >= 24
      || (parseFloat(style.fontSize) >= 18.66 && +style.fontWeight >= 700);
    const text = walker.currentNode.data.trim();
    if (ratio < (large ? 3 : 4.5)) poor.push(`${ratio.toFixed(2)} ${text}`);
  }
  return poor;
}"""
PLACE = """(name) => {
  const { top } = document.querySelector(name).getBoundingClientRect();
  const end = scrollY + innerHeight >= document.documentElement.scrollHeight - 2;
  return { top, end, reached: end || (top > -1 && top < 200) };
}"""
SPILT = """(width) => [...document.querySelectorAll('body *')].filter((e) => {
  if (e.closest('.unseen, .skip, .viewer-status, .viewer-stage, dialog')) return false;
  for (let p = e.parentElement; p && p !== document.body; p = p.parentElement) {
    if (getComputedStyle(p).overflowX !== 'visible') return false;
  }
  const box = e.getBoundingClientRect();
  return box.width > 0 && (box.right > width + 1 || box.left < -1);
}).map((e) => `${e.tagName} ${e.className.baseVal ?? e.className} ${e.textContent.slice(0, 40)}`)"""


def wait_until_ready(page: Page) -> None:
    page.wait_for_selector("#viewer[data-ready=true]", state="attached")


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_says_no_error_and_asks_for_nothing(
    page_file: Path, open_page: Callable, width: int, dark: bool
):
    opened = open_page(page_file, width=width, dark=dark)
    wait_until_ready(opened.page)
    for summary in opened.page.query_selector_all("details:not([open]) > summary"):
        summary.evaluate("one => { one.parentElement.open = true; }")
    assert opened.errors == []
    assert [one for one in opened.requests[1:] if not one.startswith(("data:", "blob:"))] == []


def test_the_unpacked_page_reads_files_beside_it_only(unpacked: Path, open_page: Callable):
    opened = open_page(unpacked / "report.html")
    wait_until_ready(opened.page)
    assert opened.errors == []
    inside = unpacked.resolve().as_uri() + "/"
    asked = [one for one in opened.requests if not one.startswith(("data:", "blob:"))]
    assert [one for one in asked if not one.startswith(inside)] == []
    assert any("/viewer/" in one for one in asked), asked


def test_every_image_decodes(page_file: Path, open_page: Callable):
    page = open_page(page_file).page
    count = page.evaluate(
        "async () => { for (const i of document.images) await i.decode();"
        " return [...document.images].filter((i) => i.naturalWidth > 0).length; }"
    )
    assert count == page.evaluate("document.images.length") > 0


@pytest.mark.parametrize("where", ["beside the results", "unpacked"])
def test_every_link_resolves(page_file: Path, unpacked: Path, open_page: Callable, where: str):
    file = page_file if where == "beside the results" else unpacked / "report.html"
    page = open_page(file).page
    links = page.evaluate("[...document.querySelectorAll('a')].map((a) => a.getAttribute('href'))")
    assert len(links) > 50
    ids = set(page.evaluate("[...document.querySelectorAll('[id]')].map((e) => e.id)"))
    views = set()
    for link in links:
        if link.startswith("#view="):
            views.add(link)
        elif link.startswith("#"):
            assert link[1:] in ids, link
        else:
            assert (file.parent / unquote(link)).is_file(), link
    wait_until_ready(page)
    for view in sorted(views):
        page.evaluate("(hash) => { location.hash = hash; }", view)
        scene, model, tracer = view.removeprefix("#view=").partition("&")[0].split("/")
        page.wait_for_function(
            "([scene, model, tracer]) => { const now = location.hash;"
            " return now.startsWith(`#view=${scene}/${model}/${tracer}`); }",
            arg=[scene, model, tracer],
        )
        assert page.eval_on_selector("[name=viewer-model]", "e => e.value") == model, view


def test_a_link_to_a_section_leads_to_its_top(page_file: Path, open_page: Callable):
    page = open_page(page_file).page
    wait_until_ready(page)
    page.emulate_media(reduced_motion="reduce")
    links = page.query_selector_all("nav a")
    missed = {}
    for link in links:
        link.click()
        name = link.get_attribute("href")
        try:
            page.wait_for_function(f"name => ({PLACE})(name).reached", arg=name)
        except PageTimeoutError:
            missed[name] = page.evaluate(PLACE, name)
    assert links and not missed, f"of {len(links)} links these lead elsewhere: {missed}"


@pytest.mark.parametrize("dark", [False, True])
def test_a_planted_regression_is_red_in_the_first_window_and_leads_to_its_place(
    page_file: Path, open_page: Callable, dark: bool
):
    page = open_page(page_file, dark=dark).page
    failed = page.query_selector_all("table.strip a.mark.fail")
    found = {one.get_attribute("href").partition("&")[0] for one in failed}
    assert found == {f"#view={'/'.join(subject)}" for subject in FAILURES}
    for one in failed:
        box = one.bounding_box()
        assert box is not None and box["y"] + box["height"] < 900, "below the first window"
        colour = one.eval_on_selector(".sign", "e => getComputedStyle(e).backgroundColor")
        red, green, blue = (int(part) for part in colour[4:-1].split(","))
        assert red > 150 and max(green, blue) < 80, colour
    scene, model, tracer = FAILURES[1]
    link = page.query_selector(f"table.strip a[href^='#view={scene}/{model}/{tracer}']")
    link.click()
    wait_until_ready(page)
    parts = dict(part.partition("=")[::2] for part in link.get_attribute("href")[1:].split("&"))
    row, column = TILE_AT
    assert column * TILE <= float(parts["x"]) <= (column + 1) * TILE, parts
    assert row * TILE <= float(parts["y"]) <= (row + 1) * TILE, parts
    assert parts["mode"] == "relative"
    stage = page.wait_for_selector(".viewer-stage")
    page.wait_for_function(
        "(e) => { const box = e.getBoundingClientRect();"
        " return box.top >= -1 && box.top < innerHeight; }",
        arg=stage,
    )


def test_the_tabulator_alone_reaches_everything(page_file: Path, open_page: Callable):
    page = open_page(page_file).page
    wait_until_ready(page)
    page.evaluate("window.reached = 0")
    wanted = set(page.evaluate(REACHABLE))
    seen: set[str] = set()
    for _ in range(KEYS_AT_MOST):
        page.keyboard.press("Tab")
        place = page.evaluate("document.activeElement.dataset.reach ?? ''")
        if place in seen or (not place and seen >= wanted):
            break
        seen.add(place)
    lost = [
        page.eval_on_selector(f"[data-reach='{one}']", "e => e.outerHTML") for one in wanted - seen
    ]
    assert not lost, lost[:5]


def test_arrows_reach_every_verdict_and_every_command(page_file: Path, open_page: Callable):
    page = open_page(page_file).page
    grid = page.query_selector("table.strip")
    grid.query_selector("tbody a").focus()
    links = len(grid.query_selector_all("tbody a"))
    seen: set[str] = set()
    for _ in grid.query_selector_all("tbody tr"):
        for key in ("ArrowRight", "ArrowLeft"):
            for _ in range(links):
                seen.add(page.evaluate("document.activeElement.getAttribute('aria-label')"))
                page.keyboard.press(key)
        page.keyboard.press("ArrowDown")
    assert len(seen) == links
    table = page.query_selector("details[open] table.data")
    buttons = table.query_selector_all("td.again > button")
    buttons[0].focus()
    for button in buttons:
        assert button.evaluate("e => e === document.activeElement")
        page.keyboard.press("Enter")
        shown = page.evaluate("document.activeElement.closest('tr').nextElementSibling.textContent")
        assert button.get_attribute("data-command") in shown
        page.keyboard.press("Enter")
        page.keyboard.press("ArrowDown")


@pytest.mark.parametrize("dark", [False, True])
def test_every_text_has_the_contrast_that_wcag_asks_for(
    page_file: Path, open_page: Callable, dark: bool
):
    page = open_page(page_file, dark=dark).page
    wait_until_ready(page)
    page.evaluate("for (const d of document.querySelectorAll('details')) d.open = true")
    assert page.evaluate(CONTRAST) == []


@pytest.mark.parametrize("width", [1440, 768, 400, 320])
def test_nothing_reaches_beyond_the_window(page_file: Path, open_page: Callable, width: int):
    page = open_page(page_file, width=width).page
    wait_until_ready(page)
    page.evaluate("for (const d of document.querySelectorAll('details')) d.open = true")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(SPILT, width) == []


def test_nothing_reaches_beyond_the_paper(page_file: Path, open_page: Callable):
    # A4 less margins of 12 mm at 96 pixels an inch, as page.css has them.
    width = int((210 - 24) / 25.4 * 96)
    page = open_page(page_file, width=width).page
    wait_until_ready(page)
    page.emulate_media(media="print")
    assert page.evaluate(SPILT, width) == []


def test_the_page_can_be_read_without_scripts(page_file: Path, open_page: Callable):
    page = open_page(page_file, java_script_enabled=False).page
    assert page.locator("table.strip a.mark").count() > 10
    assert page.locator("td.again button").first.is_hidden()


def test_a_unit_stands_at_every_axis(page_file: Path, open_page: Callable):
    page = open_page(page_file).page
    page.evaluate("for (const d of document.querySelectorAll('details')) d.open = true")
    texts = page.evaluate("[...document.querySelectorAll('.card svg')].map((s) => s.textContent)")
    units = ("second", "relMSE", "samples a pixel", "rays", "%", "cycles a pixel", "embree", "(1)")
    assert texts and all(any(unit in text for unit in units) for text in texts)


def test_inks_of_verdicts_differ_for_colour_blind_readers(page_file: Path, open_page: Callable):
    """Machado, Oliveira and Fernandes 2009, severity 1; a difference of 10 is plain to see."""
    from skimage.color import deltaE_ciede2000, rgb2lab

    deficiencies = {
        "protan": [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        "deutan": [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        "tritan": [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    }
    for dark in (False, True):
        page = open_page(page_file, dark=dark).page
        names = ("--pass-soft", "--fail-fill", "--wait-soft")
        shown = [
            page.evaluate("n => getComputedStyle(document.documentElement).getPropertyValue(n)", n)
            for n in names
        ]
        colours = (
            np.array([[int(c.strip()[k : k + 2], 16) for k in (1, 3, 5)] for c in shown]) / 255
        )
        linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
        for name, matrix in deficiencies.items():
            seen = np.clip(linear @ np.array(matrix).T, 0.0, 1.0)
            encoded = np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055)
            lab = rgb2lab(encoded[None])[0]
            for one, other in ((0, 1), (0, 2), (1, 2)):
                difference = deltaE_ciede2000(lab[one], lab[other])
                least = 10.0 if 1 in (one, other) else 2.0
                assert difference > least, (name, dark, names[one], names[other], difference)
