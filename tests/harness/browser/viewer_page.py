"""A page with nothing but the viewer, and what tests ask of it."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from numpy.typing import NDArray

from harness.viewer.pack import HERE

WITH_SOFTWARE_WEBGL = """
const getContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, options) {
  return getContext.call(this, kind, { ...options, failIfMajorPerformanceCaveat: false });
};
"""
"""As on a machine with a GPU: the WebGL that runs on the processor counts too."""

WITHOUT_WEBGL = """
const getContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, options) {
  return kind.startsWith("webgl") ? null : getContext.call(this, kind, options);
};
"""


def write_page(context: dict[str, Any], path: Path) -> Path:
    """Write a page that holds the viewer, with the report's style and text before and after it."""
    environment = Environment(
        loader=FileSystemLoader(HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = (HERE.parent / "report" / "templates" / "page.css").read_text()
    body = environment.get_template("viewer.html.j2").render(viewer=context)
    tall = '<div style="height: 1500px"></div>'
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>viewer</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<style>{style}</style></head><body><main class="wide">'
        f'<a id="before" href="#after">before</a>{tall}{body}{tall}<a id="after" href="#">after</a>'
        "</main></body></html>"
    )
    return path


def wait_until_ready(page: Any) -> None:
    """Wait for the first picture."""
    page.wait_for_selector("#viewer[data-ready]", timeout=30_000)


def change(page: Any, changes: dict[str, Any]) -> None:
    """Change the state of the viewer, and wait until that is painted."""
    page.evaluate("(changes) => hasteViewer.app.change(changes)", changes)


def stage_pixels(page: Any) -> NDArray[np.uint8]:
    """RGBA of the stage: [height, width, 4]."""
    text, width, height = page.evaluate(
        """() => {
          const { stage } = hasteViewer.app;
          const bytes = stage.pixels();
          let text = "";
          for (let i = 0; i < bytes.length; i += 8192) {
            text += String.fromCharCode(...bytes.subarray(i, i + 8192));
          }
          return [btoa(text), stage.size.width, stage.size.height];
        }"""
    )
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)


def map_values(page: Any, mode: str, a: str, b: str) -> NDArray[np.float64]:
    """Values of a mode's map of the panel that is shown, on the axis of its scale: [h, w]."""
    values, width = page.evaluate(
        """async ([mode, a, b]) => {
          const { panel } = hasteViewer.app.state;
          const [first, second] = await Promise.all([panel.image(a), panel.image(b)]);
          await hasteViewer.makeMap(panel, mode, first, second);
          const { picture } = hasteViewer.pictureOf(panel, mode, first, second,
            hasteViewer.app.state);
          const said = (value) => (Number.isFinite(value) ? value : String(value));
          return [Array.from(picture.values, said), panel.columns];
        }""",
        [mode, a, b],
    )
    return np.array([float(str(value)) for value in values]).reshape(-1, width)


def read_cells(page: Any) -> dict[str, str]:
    """Texts of the read-out by the names of its cells."""
    return page.evaluate(
        """() => Object.fromEntries([...document.querySelectorAll("#viewer [data-cell]")]
          .map((cell) => [cell.dataset.cell, cell.textContent]))"""
    )


def as_number(text: str) -> float:
    """A number as the read-out prints it."""
    return float(text.replace("−", "-").replace("∞", "inf").replace("not known", "nan"))
