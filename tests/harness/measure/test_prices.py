"""The price of features as a job, what a kernel's cost is read from, and the rows of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from harness.measure.config import Config, ConfigError
from harness.measure.kernels import WARPS_AND_BLOCKS, count_instructions, occupancy
from harness.measure.prices import price_scene
from harness.report.features import find_prices, plot_prices, price_list, priced_models
from harness.tables.lookup import Measurements, read_measurements
from harness.tables.prices import PriceJob, read_price_jobs, record_prices
from harness.tables.schema import Recorder
from harness.tracers.haste import HasteCpu

REASON = HasteCpu.unavailable()
pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")


@pytest.fixture
def compiler() -> Any:
    """The extension, where NVRTC works."""
    from haste_cuda import _core, nvrtc

    nvrtc.configure()
    reason = _core.nvrtc_unavailable()
    if reason is not None:
        pytest.skip(reason)
    return _core


@pytest.fixture
def make(make_config: Any, scene_path: Path) -> Callable[..., Config]:
    """Settings for two programs of a lamp; the keywords are those of the section `features`."""
    (scene_path.parent / "settings.yaml").write_text("models: [path]\n")

    def config(**changes: Any) -> Config:
        features = {
            "scenes": [str(scene_path)],
            "models": ["path"],
            "singly": ["triangles"],
            "compile_repeats": 1,
            "samples": {"cpu": 100, "gpu": 100},
            "repeats": 3,
        }
        tracers = ["haste-cpu", "haste-cuda"]
        return make_config(tracers=tracers, features={**features, **changes})

    return config


def no_gpu() -> str | None:
    import haste_cuda

    return haste_cuda.cuda_unavailable()


@pytest.mark.usefixtures("compiler")
def test_kernels_are_compiled_without_a_gpu_and_programs_of_the_processor_are_timed(
    make: Callable[..., Config],
):
    config = make()
    price_scene(config, "lamp", 1)
    folder = config.price_dir("lamp")
    compiled = {row["features"]: row for row in json.loads((folder / "compiled.json").read_text())}
    assert list(compiled) == ["required", "required+triangles", "all"]
    for row in compiled.values():
        assert row["status"] == "ok" and row["spill_bytes"] == 0, row
        assert len(row["compile_seconds"]) == 1 and row["compile_seconds"][0] > 0.0, row
    sizes = [row["instructions"] for row in compiled.values()]
    assert 2 * sizes[0] < sizes[2], sizes
    timed = json.loads((folder / "timed.json").read_text())
    ours = {row["features"]: row for row in timed if row["tracer"] == "haste-cpu"}
    assert list(ours) == ["required", "required+triangles", "all"]
    for row in ours.values():
        assert len(row["seconds"]) == 3 and min(row["seconds"]) > 0.0, row
        assert row["samples"] >= 100, row
    assert len({row["film_sha256"] for row in ours.values()}) == 1
    theirs = [row for row in timed if row["tracer"] == "haste-cuda"]
    reason = no_gpu()
    if reason is not None:
        assert [row["features"] for row in theirs] == list(compiled)
        assert {(row["status"], row["reason"]) for row in theirs} == {("skipped", reason)}


@pytest.mark.usefixtures("compiler")
def test_what_was_compiled_and_timed_is_not_done_again(make: Callable[..., Config]):
    config = make()
    price_scene(config, "lamp", 1)
    folder = config.price_dir("lamp")
    before = [json.loads((folder / name).read_text()) for name in ("compiled.json", "timed.json")]
    (folder / "priced.json").unlink()
    price_scene(config, "lamp", 1)
    after = [json.loads((folder / name).read_text()) for name in ("compiled.json", "timed.json")]
    assert before == after


def test_a_feature_that_there_is_not_is_refused(make: Callable[..., Config]):
    with pytest.raises(ConfigError, match="there is no feature 'fur'; the features are triangles"):
        price_scene(make(singly=["fur"]), "lamp", 1)


@pytest.mark.parametrize(
    ("registers", "architecture", "block", "share"),
    [
        # By hand: 16384 registers a part; 96 a thread are 12 units a warp: 5 warps of 16.
        (96, 90, 128, 20 / 64),
        (95, 90, 128, 20 / 64),
        (97, 90, 128, 16 / 64),
        (32, 90, 128, 1.0),
        (255, 90, 128, 8 / 64),
        (64, 90, 1024, 32 / 64),
        (16, 90, 32, 32 / 64),
        (64, 75, 128, 1.0),
        (96, 200, 128, None),
    ],
)
def test_occupancy_is_what_registers_warps_and_blocks_allow(
    registers: int, architecture: int, block: int, share: float | None
):
    assert occupancy(registers, architecture, block) == share


def test_occupancy_is_known_of_all_architectures_that_kernels_are_tested_on():
    assert {75, 80, 90, 100} <= set(WARPS_AND_BLOCKS)


def test_instructions_are_those_of_the_kernel(compiler: Any):
    def size(body: str) -> int:
        source = f'extern "C" __global__ void haste_kernel(float* x) {{ {body} }}'
        return count_instructions(compiler.compile_source(source, 90, use_cache=False)["cubin"])

    short = size("*x = 1.0f;")
    more = size("".join(f"x[{i}] = sqrtf(x[{i}]) + x[{i + 1}];" for i in range(16)))
    assert 0 < short < more, (short, more)
    with pytest.raises(ValueError, match="ELF"):
        count_instructions(b"no program")
    other = compiler.compile_source('extern "C" __global__ void f() {}', 90, use_cache=False)
    with pytest.raises(ValueError, match="no kernel haste_kernel"):
        count_instructions(other["cubin"])


def test_a_ray_is_at_most_24_bytes_longer_than_the_papers():
    """Listing 2: seven floats, a layer, two 16-bit coordinates, a bool, and what aligns it."""
    from haste_cuda import _core

    listing_2 = 7 * 4 + 4 + 2 * 2 + 4
    assert _core.ray_bytes() <= listing_2 + 24


def fabricated_job() -> PriceJob:
    """Prices of a scene: `all` takes twice the time, one feature what is required takes."""
    times = {"required": 1.0, "required+mirror": 1.0, "all": 2.0}
    jitter = (0.99, 1.0, 1.01, 1.0, 1.01, 0.99)
    kernels = {"required": 60, "required+mirror": 70, "all": 100}
    return PriceJob(
        name="room",
        title="Room",
        description={"ray_bytes": 64},
        provenance={"run": "test", "config": {"features": {"engine": "depth_first"}}},
        compiled=[
            {"model": "path", "features": name, "status": "ok", "reason": ""}
            | {"registers": count, "spill_bytes": 0, "instructions": 10 * count}
            | {"occupancy": 0.25, "compile_seconds": [1.0, 1.1, 1.05]}
            for name, count in kernels.items()
        ],
        timed=[
            {"model": "path", "tracer": "haste-cuda", "features": name, "status": "ok"}
            | {"reason": "", "samples": 1000, "seconds": [second * one for one in jitter]}
            for name, second in times.items()
        ]
        + [
            {"model": "path", "tracer": "haste-cpu", "features": "required"}
            | {"status": "skipped", "reason": "no processor", "seconds": []}
        ],
    )


@pytest.fixture
def measurements(tmp_path: Path) -> Measurements:
    """The rows of the fabricated prices, written and read back."""
    recorder = Recorder()
    record_prices(recorder, fabricated_job())
    path = tmp_path / "measurements.csv"
    recorder.frames()[1].to_csv(path, index=False)
    return read_measurements(path)


def test_a_price_is_the_ratio_of_times_with_its_interval(measurements: Measurements):
    found = {row.case: row.interval for row in measurements.rows if row.quantity == "feature_price"}
    assert set(found) == {"features=required+mirror", "features=all"}
    twice, once = found["features=all"], found["features=required+mirror"]
    assert twice.lower < 2.0 < twice.upper and twice.upper - twice.lower < 0.1, twice
    assert once.lower < 1.0 < once.upper, once


def test_every_quantity_of_a_kernel_is_a_row_and_a_skipped_time_has_its_reason(
    measurements: Measurements,
):
    own = {row.quantity for row in measurements.rows if row.case == "features=all"}
    assert own == {
        *("samples_per_second", "feature_price", "registers", "spill_bytes", "instructions"),
        *("occupancy", "compile_seconds", "bytes_per_ray"),
    }
    (skipped,) = [row for row in measurements.rows if row.status != "ok"]
    assert (skipped.tracer, skipped.quantity, skipped.note) == (
        *("haste-cpu", "samples_per_second"),
        "no processor",
    )


def test_the_report_draws_time_and_registers_and_lists_all(measurements: Measurements):
    prices = find_prices(measurements)
    assert priced_models(prices) == ["path"]
    figure = plot_prices(prices, "path")
    assert figure is not None
    time, registers = figure.axes
    assert [text.get_text() for text in time.texts] == ["+0", "+100"]
    assert [text.get_fontweight() for text in time.texts] == ["normal", "bold"]
    assert [text.get_text() for text in registers.texts] == ["+10", "+40"]
    table = price_list(prices)
    assert table is not None
    assert table.frame["features"].tolist() == ["required", "required+mirror", "all", "required"]
    assert plot_prices(prices, "haste") is None
    assert price_list([]) is None


def test_a_run_without_prices_has_none(tmp_path: Path):
    assert read_price_jobs(tmp_path) == []
    (tmp_path / "settings.json").write_text("{}")
    assert read_price_jobs(tmp_path) == []
    assert find_prices(SimpleNamespace(rows=())) == []
