from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reference.mitsuba import UnavailableVariantError, render_truth
from reference.mitsuba import truth as module

BATCHES = 16


@pytest.fixture
def scene(active: str) -> dict[str, Any]:
    del active
    import mitsuba as mi

    place = mi.ScalarTransform4f().look_at(origin=[0, -4, 1], target=[0, 0, 0.5], up=[0, 0, 1])
    return {
        "type": "scene",
        "sensor": {"type": "perspective", "to_world": place},
        "floor": {"type": "rectangle", "bsdf": {"type": "phong", "reflection": 0.2}},
        "light": {
            "type": "sphere",
            "radius": 0.3,
            "center": [0, 0, 1],
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1, 2, 3]}},
        },
    }


def contents(folder: Path) -> dict[str, tuple[bytes, int]]:
    return {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in folder.iterdir()}


def make(scene: dict[str, Any], settings: Any, folder: Path, **changes: Any) -> dict[str, Any]:
    arguments = {"batches": BATCHES, "spp": 4, "seed": 1_000_000} | changes
    return render_truth(scene, settings("haste", 8), out_dir=folder, **arguments)


def test_mean_and_variance_are_those_of_the_batches(scene: Any, settings: Any, tmp_path: Path):
    import OpenEXR

    record = make(scene, settings, tmp_path)
    batches = [np.load(tmp_path / f"batch_{k:03d}.npy") for k in range(BATCHES)]
    assert all(batch.shape == (8, 8, 3) and batch.dtype == np.float32 for batch in batches)
    images = np.stack(batches).astype(np.float64)
    assert len({batch.tobytes() for batch in batches}) == BATCHES
    for name, expected in (("mean", images.mean(0)), ("variance", images.var(0, ddof=1))):
        pixels = OpenEXR.File(str(tmp_path / f"{name}.exr")).channels()["RGB"].pixels
        assert pixels.dtype == np.float32
        assert np.array_equal(pixels, expected.astype(np.float32)), name
    assert record["complete"] and record == json.loads((tmp_path / "truth.json").read_text())
    assert record["settings"]["model"] == "haste" and record["variant"] == "llvm_ad_rgb"


def test_a_complete_truth_is_not_touched(scene: Any, settings: Any, tmp_path: Path):
    make(scene, settings, tmp_path)
    before = contents(tmp_path)
    lines: list[str] = []
    make(scene, settings, tmp_path, progress=lines.append)
    assert contents(tmp_path) == before and lines == []


def test_an_interrupted_truth_renders_only_what_is_missing(
    scene: Any, settings: Any, tmp_path: Path
):
    make(scene, settings, tmp_path)
    before = contents(tmp_path)
    (tmp_path / "batch_005.npy").unlink()
    whole = (tmp_path / "batch_007.npy").read_bytes()
    (tmp_path / "batch_007.npy").write_bytes(whole[: len(whole) // 2])
    lines: list[str] = []
    make(scene, settings, tmp_path, progress=lines.append)
    after = contents(tmp_path)
    assert [line.split(":")[0] for line in lines] == ["batch 6 of 16", "batch 8 of 16"]
    for k in set(range(BATCHES)) - {5, 7}:
        name = f"batch_{k:03d}.npy"
        assert after[name] == before[name], f"{name} was rendered again"
    # Dr.Jit adds samples in any order, so a repeated batch is the same up to rounding.
    again = np.load(tmp_path / "batch_005.npy")
    make(scene, settings, tmp_path / "fresh")
    assert np.allclose(again, np.load(tmp_path / "fresh" / "batch_005.npy"), rtol=1e-5)
    assert not list(tmp_path.glob(".partial-*"))


def test_other_settings_render_everything_again(scene: Any, settings: Any, tmp_path: Path):
    first = make(scene, settings, tmp_path)
    before = contents(tmp_path)
    second = make(scene, settings, tmp_path, spp=5)
    after = contents(tmp_path)
    assert first["key"] != second["key"] and first["batch_key"] != second["batch_key"]
    assert all(before[f"batch_{k:03d}.npy"] != after[f"batch_{k:03d}.npy"] for k in range(BATCHES))


def test_more_batches_keep_those_that_are_there(scene: Any, settings: Any, tmp_path: Path):
    make(scene, settings, tmp_path)
    before = contents(tmp_path)
    make(scene, settings, tmp_path, batches=18)
    after = contents(tmp_path)
    assert all(before[f"batch_{k:03d}.npy"] == after[f"batch_{k:03d}.npy"] for k in range(BATCHES))
    assert before["mean.exr"] != after["mean.exr"] and "batch_017.npy" in after
    make(scene, settings, tmp_path)
    assert "batch_016.npy" not in contents(tmp_path)


def test_a_changed_scene_has_another_key(scene: Any, settings: Any, tmp_path: Path):
    first = make(scene, settings, tmp_path)
    changed = scene | {"floor": scene["floor"] | {"bsdf": {"type": "phong", "reflection": 0.3}}}
    assert make(changed, settings, tmp_path)["key"] != first["key"]


def test_too_few_batches_are_refused(scene: Any, settings: Any, tmp_path: Path):
    with pytest.raises(ValueError, match="16 batches"):
        make(scene, settings, tmp_path, batches=15)


@pytest.mark.parametrize("model", ["haste", "path"])
def test_without_llvm_the_error_names_the_package(
    scene: Any, settings: Any, model: str, monkeypatch: pytest.MonkeyPatch
):
    reason = "Dr.Jit needs LLVM: apt-get install libllvm19"
    monkeypatch.setattr(module, "available", lambda _: reason)
    with pytest.raises(UnavailableVariantError, match="apt-get install libllvm19"):
        module.choose_variant(scene, settings(model, 8))


def test_without_llvm_native_scenes_fall_back_to_the_scalar_variant(
    scene: Any, settings: Any, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(module, "available", lambda _: "no LLVM")
    native = scene | {"floor": {"type": "rectangle", "bsdf": {"type": "diffuse"}}}
    assert module.choose_variant(native, settings("path", 8)) == "scalar_rgb"


def test_a_pixel_that_is_not_finite_is_named():
    image = np.zeros((4, 5, 3))
    image[2, 3, 1] = np.nan
    with pytest.raises(FloatingPointError, match=r"batch 3: 1 pixels .* x = 3, y = 2"):
        module._check_finite(image, "batch 3")
