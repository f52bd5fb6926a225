"""Pages in headless Chromium, as a reader opens them: from a disk, without a network."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from planted_page import plant
from playwright.sync_api import Browser, ConsoleMessage, Error, Page, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""What distributions call it."""
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Containers have no user namespaces to make a sandbox of; WebGL is drawn by the processor."""


@dataclass
class Opened:
    """A page, and what it has said and asked for since it was opened."""

    page: Page
    errors: list[str] = field(default_factory=list)
    """of the console and of scripts"""
    requests: list[str] = field(default_factory=list)
    """addresses, the page's own first"""

    def _said(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.errors.append(message.text)

    def listen(self) -> None:
        """Note errors and requests from here on."""
        self.page.on("console", self._said)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """A headless Chromium; tests are skipped where there is none that starts."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("not installed: chromium (apt-get install chromium)")
    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        except Error as error:
            pytest.skip(f"{path} does not start: {str(error).splitlines()[0]}")
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium: Browser) -> Iterator[Callable[..., Opened]]:
    """Open a file in a window of its own; arguments as of the function within."""
    contexts = []

    def open_file(
        path: Path,
        *,
        hash: str = "",  # noqa: A002 - what browsers call that part of an address
        width: int = 1440,
        height: int = 900,
        dark: bool = False,
        script: str = "",
        **more: Any,
    ) -> Opened:
        context = chromium.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if dark else "light",
            **more,
        )
        contexts.append(context)
        opened = Opened(context.new_page())
        opened.listen()
        if script:
            opened.page.add_init_script(script)
        opened.page.goto(path.resolve().as_uri() + hash)
        return opened

    yield open_file
    for context in contexts:
        context.close()


@pytest.fixture(scope="session")
def page_file(fabricated_results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """report.html of fabricated results with two planted errors, for reading only."""
    folder = tmp_path_factory.mktemp("planted") / "results"
    shutil.copytree(fabricated_results, folder)
    return plant(folder)


@pytest.fixture(scope="session")
def unpacked(page_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that report.zip unpacks into."""
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(page_file.parent / "report.zip") as archive:
        archive.extractall(folder)
    return folder / "haste-report"
