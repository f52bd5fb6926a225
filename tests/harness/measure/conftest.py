"""A scene of one lit sphere, and a run of two fake tracers on it."""

import json
from pathlib import Path
from typing import Any

import fake_tracers
import pytest

from harness.measure.config import Config, load_config, merge
from harness.tracers.registry import TRACERS

SCENE = """<scene version="3.0.0">
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
  </sensor>
  <shape type="sphere" id="lamp">
    <emitter type="area"><rgb name="radiance" value="1,1,1"/></emitter>
  </shape>
</scene>
"""


@pytest.fixture
def scene_path(tmp_path: Path) -> Path:
    folder = tmp_path / "lamp"
    folder.mkdir()
    (folder / "scene.xml").write_text(SCENE)
    return folder / "scene.xml"


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """Put fake tracers in the place of real ones: ``fake(embree="SteadyA")``."""
    path = tmp_path / "calls.log"
    path.touch()
    monkeypatch.setenv(fake_tracers.LOG_VARIABLE, str(path))

    def register(**classes: str) -> None:
        for name, kind in classes.items():
            monkeypatch.setitem(TRACERS, name.replace("_", "-"), f"fake_tracers:{kind}")

    register.calls = lambda: path.read_text().splitlines()
    return register


@pytest.fixture
def make_config(scene_path: Path, tmp_path: Path) -> Any:
    """Settings of a tiny run; keyword arguments are merged over them."""

    def make(**changes: Any) -> Config:
        tiny = {
            "preset": "test",
            "results_dir": str(tmp_path / "results"),
            "miniature": True,
            "scenes": [str(scene_path)],
            "models": ["path"],
            "tracers": ["haste-cpu", "embree"],
            "resolution": [8, 8],
            "seeds": {"count": 3, "spp": {"path": 4}},
            "convergence": {"models": ["path"], "doublings": 1, "seeds": 2, "most_seeds": 2},
            "timing": {"repeats": 2, "spp": {"path": 4, "whitted": 4}},
            "packets": {
                "scenes": ["lamp"],
                "models": ["path"],
                "sizes": [1, 64],
                "spp": 2,
                "repeats": 2,
            },
            "scene_settings": {},
            "tracer_settings": {},
        }
        file = tmp_path / "config.json"
        file.write_text(json.dumps(merge(tiny, changes)))
        return load_config(file)

    return make
