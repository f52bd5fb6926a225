"""Small scenes as text, so that a test shows only what it is about."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path

import pytest

SENSOR = """
<sensor type="perspective" id="camera">
    <transform name="to_world"><lookat origin="0,-5,1" target="0,0,0" up="0,0,1"/></transform>
    <film type="hdrfilm">
        <integer name="width" value="16"/><integer name="height" value="12"/>
    </film>
</sensor>
"""

WriteScene = Callable[..., Path]
GENERATORS = Path(__file__).parents[3] / "scenes" / "generators"


@pytest.fixture
def write_scene(tmp_path: Path) -> WriteScene:
    """Write an XML scene of a body and, unless another is given, a sensor; returns its file."""

    def write(body: str, *, sensor: str = SENSOR, name: str = "scene.xml") -> Path:
        file = tmp_path / name
        file.write_text(f'<scene version="3.0.0">\n{body}\n{sensor}\n</scene>\n')
        return file

    return write


@pytest.fixture
def write_ply(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """The writer of the scenes' own assets: (file, vertices, triangles, normals)."""
    monkeypatch.syspath_prepend(str(GENERATORS))
    writer: Callable[..., None] = importlib.import_module("ply").write_ply
    return writer
