"""The rows of the trade: a shortcut's error, its crossover, and what to use at a budget.

The fabricated `haste` is the picture of `path` times 1.7 with a third of its variance: wrong as it
is, right after its exposure was set.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.report.budget_table import Way, as_good, budget_table, crossover_table, ways
from harness.statistics.intervals import Interval
from harness.tables import read_jobs
from harness.tables.lookup import Measurements, read_measurements

RAW, SCALED = "exposure=raw;truth=path", "exposure=scaled;truth=path"


@pytest.fixture(scope="module")
def measurements(written_results: Path) -> Measurements:
    return read_measurements(written_results / "measurements.csv")


Find = Callable[..., Interval]


@pytest.fixture
def find(measurements: Measurements) -> Find:
    """A measured quantity of the Cornell box by Embree, which must be there."""

    def found(quantity: str, model: str, case: str = "", tracer: str = "embree") -> Interval:
        where = {"scene": "cornell-box", "model": model, "tracer": tracer}
        interval = measurements.find(quantity, case=case, **where)
        assert interval is not None, (quantity, model, case)
        return interval

    return found


def test_the_exposure_is_found_and_leaves_no_bias(find: Find):
    assert find("exposure_scale", "haste", "truth=path").value == pytest.approx(1 / 1.7, rel=0.01)
    # Eight images of 64 samples know the mean to a third of a per cent.
    assert find("relative_bias", "haste", "truth=path").value == pytest.approx(0.7, abs=0.02)
    assert abs(find("relative_bias_scaled", "haste", "truth=path").value) < 0.01
    left = find("relative_bias_squared", "haste", SCALED)
    assert left.lower <= 0.0 <= left.upper, left
    # 0.7^2 r^2 / (r^2 + epsilon), which a few dark pixels lower.
    assert 0.3 < find("relative_bias_squared", "haste", RAW).value < 0.49


def test_the_crossover_is_the_gain_in_variance_over_the_bias(find: Find):
    gain = (
        find("relative_ttuv_seconds", "path").value
        - find("relative_ttuv_seconds", "haste", RAW).value
    )
    bias = find("relative_bias_squared", "haste", RAW).value
    seconds = find("crossover_seconds", "haste", "exposure=raw;to=embree;truth=path")
    assert seconds.value == pytest.approx(gain / bias, rel=1e-6)
    assert seconds.lower < seconds.value < seconds.upper


def test_a_shortcut_without_bias_pays_forever(find: Find):
    seconds = find("crossover_seconds", "haste", "exposure=scaled;to=embree;truth=path")
    assert seconds.upper == np.inf
    assert seconds.lower > 0.0, seconds


def test_the_exact_model_s_error_falls_with_the_time(find: Find):
    ttuv = find("relative_ttuv_seconds", "path").value
    for seconds in (0.1, 1.0, 10.0, 100.0):
        found = find("relmse_at", "path", f"seconds={seconds}")
        assert found.value == pytest.approx(ttuv / seconds, rel=1e-6)
    assert find("seconds_to_relmse", "path", "target=0.01").value == pytest.approx(ttuv / 0.01)


def test_no_time_brings_the_error_below_the_bias(find: Find):
    case = "exposure=raw;target=0.1;truth=path"
    assert find("seconds_to_relmse", "haste", case).value == np.inf
    assert find("spp_to_relmse", "haste", case).lower == np.inf


def test_a_speed_up_is_the_ratio_of_the_times_to_unit_variance(find: Find):
    found = find("speed_up", "path", "to=haste-cpu")
    other = find("relative_ttuv_seconds", "path", tracer="haste-cpu").value
    own = find("relative_ttuv_seconds", "path").value
    assert found.value == pytest.approx(other / own, rel=1e-6)
    # The times of both spread by 2 % over five repeats; a variance of eight seeds by sqrt(2 / 7)
    # over 32 * 32 pixels with noise of their own in three channels.
    tolerance = 4.0 * np.sqrt(2.0 * (0.02**2 / 5 + 2.0 / 7 / (32 * 32 * 3)))
    assert np.log(found.value / 1.5) == pytest.approx(0.0, abs=tolerance), (found, tolerance)
    assert found.lower < found.value < found.upper, found


def test_quantiles_and_effective_pixels_lie_where_they_must(find: Find):
    quantiles = [
        find("relmse_quantile", "path", f"quantile={share};seeds=8;spp=64").value
        for share in (0.1, 0.5, 0.9)
    ]
    assert quantiles == sorted(quantiles)
    assert 1.0 < find("effective_pixels", "path").value < 32 * 32


def test_the_budget_names_the_cheaper_shortcut_and_the_file_ranks_all(
    written_results: Path, measurements: Measurements
):
    table = budget_table(measurements, read_jobs(written_results))
    assert table is not None
    assert len(table.columns) == 1 + 4 + 3
    frame = table.frame
    first = frame[(frame.scene == "cornell-box") & (frame.seconds == 1.0) & (frame["rank"] == 1)]
    assert list(first.model) == ["whitted"], "it has noise at edges only"
    everything = frame[(frame.scene == "cornell-box") & (frame.seconds == 1.0)]
    # Three tracers of path, two each of haste and whitted, all but path after their exposure.
    assert len(everything) == 7
    assert list(everything.value) == sorted(everything.value)


def test_the_crossover_table_has_a_row_for_every_shortcut(
    written_results: Path, measurements: Measurements
):
    table = crossover_table(measurements, read_jobs(written_results))
    assert table is not None
    (_, rows), *_ = table.groups
    # Two tracers, two models, two exposures.
    assert len(rows) == 8
    assert len(table.frame) == 2 * 8 * 3


def test_as_good_is_what_the_best_s_interval_reaches():
    best = Way("embree", "path", Interval(1.0, 0.9, 1.1, 8))
    near = Way("haste-cpu", "path", Interval(1.2, 1.05, 1.4, 8))
    far = Way("haste-cpu", "haste", Interval(1.3, 1.2, 1.4, 8))
    assert as_good([best, near, far]) == [near]


def test_a_budget_without_a_measurement_names_nothing(measurements: Measurements):
    assert ways(measurements.rows, "relmse_at", "seconds", 17.0) == []
