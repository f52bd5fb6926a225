"""What turning a knob costs, on images whose bias is known: uniform factors of the exact ones."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.report.budget_table import budget_table, crossover_table, ways
from harness.report.knobs_table import knobs_table
from harness.report.tables import error_table
from harness.report.trade_figure import curves_of, plot_trade
from harness.report.turns import name_of_turn
from harness.report.write import write_report
from harness.statistics.intervals import Interval
from harness.tables import read_jobs, write_tables
from harness.tables.lookup import Measurements, read_measurements

Find = Callable[..., Interval]
WHERE = {"scene": "cornell-box", "tracer": "embree"}


@pytest.fixture(scope="module")
def written(turned_results: Path) -> Path:
    write_tables(turned_results)
    return turned_results


@pytest.fixture(scope="module")
def measurements(written: Path) -> Measurements:
    return read_measurements(written / "measurements.csv")


@pytest.fixture
def find(measurements: Measurements) -> Find:
    """A measured quantity of the Cornell box by Embree, which must be there."""

    def found(quantity: str, case: str, model: str = "path") -> Interval:
        interval = measurements.find(quantity, case=case, model=model, **WHERE)
        assert interval is not None, (quantity, model, case)
        return interval

    return found


@pytest.mark.parametrize(
    ("case", "factor"), [("max_depth=2", 0.7), ("clamp=10.0;max_depth=64", 0.9)]
)
def test_a_bias_is_found_as_it_is_and_gone_after_one_scale(find: Find, case: str, factor: float):
    # The images are float32, whose factor is rounded.
    assert find("relative_bias", case).value == pytest.approx(factor - 1.0, abs=1e-6)
    assert find("relative_bias_scaled", case).value == pytest.approx(0.0, abs=1e-6)
    assert find("exposure_scale", case).value == pytest.approx(1.0 / factor, rel=1e-6)


def test_the_crossover_of_a_depth_limit_is_its_gain_over_its_bias(find: Find):
    case = "exposure=raw;max_depth=2"
    gain = (
        find("relative_ttuv_seconds", "max_depth=64").value
        - find("relative_ttuv_seconds", case).value
    )
    bias = find("relative_bias_squared", case).value
    found = find("crossover_seconds", "exposure=raw;max_depth=2;to=embree")
    assert found.value == pytest.approx(gain / bias, rel=1e-6)
    assert 0.0 < found.lower < found.value < found.upper < np.inf, found


def test_a_clamp_without_a_bias_after_its_scale_pays_for_as_long_as_it_is_quieter(find: Find):
    # Scaled back, the clamped images are the exact ones but for rounding.
    bias = find("relative_bias_squared", "clamp=10.0;exposure=scaled;max_depth=64")
    assert abs(bias.value) < 1e-9, bias
    crossover = find("crossover_seconds", "clamp=10.0;exposure=raw;max_depth=64;to=embree")
    assert np.isfinite([crossover.value, crossover.lower, crossover.upper]).all(), crossover


def test_a_turn_that_changes_no_bit_has_no_crossover_and_says_why(measurements: Measurements):
    rows = [
        row
        for row in measurements.rows
        if row.quantity == "crossover_seconds" and "clamp=1000" in row.case
    ]
    assert [row.status for row in rows] == ["skipped", "skipped"], rows
    assert all("exact variant" in row.note for row in rows), rows


def test_roulette_is_judged_by_its_variance_and_time(find: Find):
    case = "exposure=raw;max_depth=64;rr_depth=5"
    ttuv = find("relative_ttuv_seconds", case).value
    exact = find("relative_ttuv_seconds", "max_depth=64").value
    found = find("speed_up", "max_depth=64;rr_depth=5;to=embree")
    assert found.value == pytest.approx(exact / ttuv, rel=1e-6)
    # 1.5 times the variance in 0.4 of the time; eight images know it to some per cent.
    assert found.lower < 1.0 / (1.5 * 0.4) < found.upper, found
    # It changes no mean: the error at a time is its variance alone.
    at_one = find("relmse_at", "exposure=raw;max_depth=64;rr_depth=5;seconds=1.0")
    assert at_one.value == pytest.approx(ttuv, rel=1e-6)


def test_the_error_of_path_has_what_its_own_depth_limit_leaves_out(find: Find):
    limit = find("relative_bias_squared", "exposure=raw;max_depth=8").value
    ttuv = find("relative_ttuv_seconds", "").value
    assert limit > 0.0
    assert find("relmse_at", "seconds=100.0").value == pytest.approx(limit + ttuv / 100, rel=1e-6)


def test_what_a_tracer_cannot_turn_is_a_skipped_row_with_its_reason(measurements: Measurements):
    (row,) = [row for row in measurements.rows if "film=" in row.case]
    assert (row.status, row.note) == ("skipped", "embree has no choice of film")


def test_more_samples_a_hit_of_haste_are_measured_against_fewer(find: Find):
    case = "ambient_samples=4;light_samples=4;to=embree"
    found = find("speed_up", case, "haste")
    # A quarter of the variance in three times the time.
    assert found.lower < 4.0 / 3.0 < found.upper, found
    raw = "ambient_samples=4;exposure=raw;light_samples=4;truth=path"
    assert find("relative_bias_squared", raw, "haste").value > 0.3


def test_the_budget_names_what_was_turned(measurements: Measurements):
    found = ways(measurements.rows, "relmse_at", "seconds", 100.0)
    names = [way.name for way in found]
    assert "embree path, rr_depth 5" in names and "embree path, max_depth 2" in names, names
    assert "embree haste, 4 light × 4 ambient" in names, names
    assert "embree path, max_depth 8" not in names, "the scene's own is there without a turn"
    assert len(names) == len(set(names)), names


def test_the_tables_keep_models_and_knobs_apart(written: Path, measurements: Measurements):
    jobs = read_jobs(written)
    crossover, knobs = crossover_table(measurements, jobs), knobs_table(measurements, jobs)
    assert crossover is not None and knobs is not None
    assert set(crossover.frame.model) == {"haste", "whitted"}
    assert len(crossover.frame) == 2 * 2 * 2 * 3, "models, tracers, exposures, tracers of path"
    # Six turns of path, a film that Embree has not, two of haste.
    assert len(knobs.frame) == 6 + 1 + 2, knobs.frame
    (_, rows), *_ = knobs.groups
    turned = [row[1].text for row in rows]
    assert turned[:3] == [f"path, max_depth {depth}" for depth in (2, 8, 64)], turned
    assert budget_table(measurements, jobs) is not None


def test_the_plane_has_a_panel_for_tracers_models_and_knobs(
    written: Path, measurements: Measurements
):
    (job,) = read_jobs(written)
    figure = plot_trade(measurements, job)
    assert figure is not None
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == [
        "tracers of path",
        "models, their exposure set",
        "knobs of path, embree",
        "samples a hit of haste, embree",
    ]
    legend = figure.axes[2].get_legend()
    assert legend is not None
    entries = [text.get_text() for text in legend.get_texts()]
    assert len(entries) == 6 and entries[0].startswith("max_depth 2  T* "), entries
    curves = curves_of(measurements, job)
    limits = {
        curve.bias_squared.value for curve in curves if curve.model == "path" and not curve.turned
    }
    assert len(limits) == 1 and limits != {0.0}, "the scene's own limit counts for every tracer"


def test_without_a_sweep_there_are_planes_of_tracers_and_models(written_results: Path):
    found = read_measurements(written_results / "measurements.csv")
    for job in read_jobs(written_results):
        figure = plot_trade(found, job)
        assert figure is not None
        assert len([axes for axes in figure.axes if axes.get_title(loc="left")]) == 2


def test_turned_images_are_none_of_those_whose_error_is_tabled(
    written: Path, measurements: Measurements
):
    frame = error_table(measurements, read_jobs(written)).frame
    assert set(frame.spp.astype(int)) == {64}, "the turned images have 16 samples a pixel"


def test_the_report_shows_planes_and_knobs(written: Path):
    page = write_report(written).read_text()
    assert 'id="trade"' in page and "What turning a knob costs" in page
    assert (written / "figures" / "trade-cornell-box.svg").exists()
    assert (written / "tables" / "knobs.csv").exists()


@pytest.mark.parametrize(
    ("turned", "name"),
    [
        ({"max_depth": 64}, "max_depth 64"),
        ({"max_depth": 64, "rr_depth": 5}, "rr_depth 5"),
        ({"max_depth": 64, "clamp": 0.5}, "clamp 0.5"),
        ({"max_depth": 64, "film": "float_atomic"}, "float_atomic"),
        ({"light_samples": 4, "ambient_samples": 1}, "4 light × 1 ambient"),
        ({}, ""),
    ],
)
def test_a_turn_is_named_by_its_knob(turned: dict[str, int | float | str], name: str):
    assert name_of_turn(turned) == name
