"""The gate on fabricated results: what passes, what fails, and the exit code of each."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.gate import check

Fabricate = Callable[..., Path]
SMALL = {"scenes": ("cornell-box",), "models": ("path",)}
SHARP = {"spp": 256, "seeds": 16}


def lines_of(capsys: pytest.CaptureFixture[str], word: str) -> list[str]:
    return [line for line in capsys.readouterr().out.splitlines() if word in line]


def test_equal_images_pass(fabricated_results: Path, capsys: pytest.CaptureFixture[str]):
    code = check(fabricated_results)
    out = capsys.readouterr().out
    assert code == 0, out
    assert "14 pass, 0 fail" in out
    assert "libcuda.so.1 cannot be opened" in out


def test_a_planted_one_per_cent_error_fails(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(**SMALL, **SHARP, changes={"haste-cpu": lambda image: 1.01 * image})
    assert check(folder) == 1
    (line,) = lines_of(capsys, "haste-cpu")
    assert line.startswith("FAIL")
    assert "within ±0.50%: FAIL" in line


def test_a_planted_ten_per_cent_tile_fails_although_the_mean_passes(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    def plant(image: np.ndarray) -> np.ndarray:
        changed = image.copy()
        changed[8:16, 16:24] *= 1.1
        return changed

    folder = fabricate_results(**SMALL, **SHARP, changes={"embree": plant})
    assert check(folder) == 1
    (line,) = lines_of(capsys, "embree")
    assert "within ±0.50%: PASS" in line
    assert "row 1, column 2" in line
    assert line.startswith("FAIL")


def test_a_caustic_scene_has_its_own_bound(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(
        scenes=("mirror-glass",),
        models=("path",),
        **SHARP,
        changes={"embree": lambda image: 1.007 * image},
    )
    gate = {"delta": 0.005, "caustic_delta": 0.01, "alpha": 0.01, "tile": 8}
    check(folder, gate)
    assert "within ±1.00%: PASS" in lines_of(capsys, "embree")[0]
    check(folder, gate | {"caustic_delta": 0.005})
    assert "within ±0.50%: FAIL" in lines_of(capsys, "embree")[0]


def test_too_few_samples_are_no_pass(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(**SMALL, seeds=3, spp=1)
    assert check(folder) == 2
    (line,) = lines_of(capsys, "haste-cpu")
    assert line.startswith("NOT ENOUGH SAMPLES")
    assert "seeds" in line


def test_a_pixel_that_is_not_finite_fails(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(**SMALL)
    path = folder / "scenes/cornell-box/seeds/path/embree/seed_002.npy"
    image = np.load(path)
    image[3, 4, 1] = np.nan
    np.save(path, image)
    assert check(folder) == 1
    (line,) = lines_of(capsys, "embree")
    assert "1 not finite" in line


def test_a_negative_pixel_fails(fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]):
    folder = fabricate_results(**SMALL)
    path = folder / "scenes/cornell-box/seeds/path/embree/seed_002.npy"
    image = np.load(path)
    image[3, 4, 1] = -1e-6
    np.save(path, image)
    assert check(folder) == 1
    assert "1 negative" in capsys.readouterr().out


def test_a_tracer_that_ignores_its_seed_fails(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(**SMALL)
    seeds = folder / "scenes/cornell-box/seeds/path/embree"
    for path in seeds.glob("*.npy"):
        np.save(path, np.load(seeds / "seed_000.npy"))
    assert check(folder) == 1
    assert "images of different seeds are equal" in capsys.readouterr().out


def test_a_crashed_tracer_fails_and_the_rest_is_judged(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(**SMALL)
    path = folder / "scenes/cornell-box/skipped.json"
    rows = json.loads(path.read_text())
    reason = "embree: its process died (killed by SIGSEGV), without a word"
    rows.append({"tracer": "embree", "model": "path", "status": "failed", "reason": reason})
    path.write_text(json.dumps(rows))
    assert check(folder) == 1
    out = capsys.readouterr().out
    assert "SIGSEGV" in out
    assert "2 pass, 1 fail" in out


def test_a_tracer_that_vanishes_without_a_reason_fails(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(models=("path",))
    seeds = folder / "scenes/mirror-glass"
    for kind in ("seeds", "convergence"):
        for path in (seeds / kind / "path/embree").iterdir():
            path.unlink()
    assert check(folder) == 1
    assert "mirror-glass path embree: neither images nor a reason" in capsys.readouterr().out


def test_a_sparse_sample_of_mitsuba_delays_no_verdict(fabricate_results: Fabricate):
    folder = fabricate_results(**SMALL)
    for path in (folder / "scenes/cornell-box/seeds/path/mitsuba-llvm").glob("seed_*"):
        if int(path.stem[-1]) > 2:
            path.unlink()
    assert check(folder) == 0


def test_a_tile_test_without_power_is_no_pass(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = fabricate_results(scenes=("cornell-box",), models=("haste",), seeds=4, spp=64)
    gate = {"delta": 0.05, "caustic_delta": 0.05, "alpha": 1e-6, "tile": 8}
    assert check(folder, gate) == 2
    (line,) = lines_of(capsys, "embree")
    assert "within ±5.00%: PASS" in line
    assert line.startswith("NOT ENOUGH SAMPLES")


def test_nothing_to_judge_is_no_pass(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert check(tmp_path) == 1
    assert "no scene job has been written here" in capsys.readouterr().err
