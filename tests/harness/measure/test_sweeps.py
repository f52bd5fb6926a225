"""Scenes at their extremes: what they show, what is measured, and how far each tracer holds."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from harness.measure.config import Config
from harness.report.stability_matrix import (
    LINES,
    Curve,
    Point,
    find_curves,
    held,
    make_stability_matrix,
    plot_family,
    power,
)
from harness.report.stability_page import trade_lines, trade_table
from harness.report.stability_worst import plot_worst, worst_rows
from harness.stability.hazards import HAZARDS, KINDS, Extreme, Hazard, lamp_over_floor
from harness.stability.sweeps import measure_sweeps
from harness.statistics.intervals import Interval
from harness.tables.lookup import Measurement, Measurements
from harness.tables.schema import Recorder, format_case
from harness.tables.sweeps import SweepsJob, read_sweeps_job, record_sweeps
from harness.tracers.haste import HasteCpu

REASON = HasteCpu.unavailable()
needs_extension = pytest.mark.skipif(REASON is not None, reason=REASON or "")

VALUES = {
    "scale": [1e-6, 1e6],
    "distance": [1e6],
    "distance_recentred": [1e6],
    "eye": [1000.0],
    "light_distance": [1e-3, 1e6],
    "light_size": [1e-3, 1e6],
    "radiance": [1e-30, 1e8],
    "grazing": [0.01],
    "slivers": [1e7],
    "triangles": [0, 1, 2, 3],
    "phong": [1e6],
    "depth": [1000],
    "samples": [1e6],
}
"""Extremes that watertight and fp64 hold, but for `distance`, where nobody can."""


@pytest.fixture
def make(make_config: Any) -> Callable[..., Config]:
    """Settings for some values."""

    def config(tracers: list[str], values: dict[str, list[float]]) -> Config:
        stability = {
            "scenes": [],
            "count": 1,
            "scales": [1.0],
            "eyes": [1.0],
            "traversals": [],
            "seed": 0,
            "most": {},
            "modes": {"scenes": [], "resolution": [16, 16], "images": 2},
            "surfaces": {"scales": [1.0], "eyes": [1.0], "gaps": [1e-5], "images": 1},
            "sweeps": {"values": values, "images": 4, "most_samples": {"embree": 100_000}},
        }
        return make_config(tracers=tracers, stability=stability)

    return config


@needs_extension
def test_the_extremes_hold_where_they_can_and_the_rows_say_so(make: Callable[..., Config]):
    config = make(["haste-cpu", "embree", "haste-cuda"], VALUES)
    record = json.loads(measure_sweeps(config, 2).read_text())
    held_by: dict[tuple[str, str], dict[tuple[str, float], Any]] = {}
    for row in record["rows"]:
        key = (row["tracer"], row["precision"])
        held_by.setdefault(key, {})[row["hazard"], row["value"]] = row
    for precision in ("watertight", "fp64"):
        for (hazard, value), row in held_by["haste-cpu", precision].items():
            assert row["status"] == "ok" and row["non_finite"] == 0, row
            off = max(abs(row["error"]["lower"]), abs(row["error"]["upper"]))
            if hazard == "distance":
                assert off > 0.1, f"{precision}: {row}: the sweep sees nothing"
            else:
                assert off <= 1e-3, f"{hazard} {value:g}, {precision}: {row}"
    fast = held_by["haste-cpu", "fast"]
    assert fast["slivers", 1e7]["error"]["value"] > 0.01, "fast arithmetic should see the sky"
    too_many = held_by["embree", "robust"]["samples", 1e6]
    assert too_many["status"] == "skipped" and "1000000 samples" in too_many["reason"]
    assert {row["status"] for row in held_by["haste-cuda", "fast"].values()} <= {"ok", "skipped"}
    (config.results_dir / "settings.json").write_text(json.dumps(config.values))
    job = read_sweeps_job(config.results_dir)
    assert job is not None
    recorder = Recorder()
    record_sweeps(recorder, job)
    frame = recorder.frames()[1]
    assert set(frame["quantity"]) == {"closed_form_error", "non_finite_ppm"}
    assert "distance=1000000.0;recentred=yes" in set(frame["case"])
    shown = [(row["hazard"], row["precision"]) for row in worst_rows(record)]
    assert ("slivers", "fast") in shown and "distance" in {hazard for hazard, _ in shown}
    assert "samples" not in {hazard for hazard, _ in shown}, "that holds, and has no image"
    assert plot_worst(config.results_dir) is not None
    assert plot_worst(config.results_dir / "nothing") is None


@needs_extension
def test_an_image_that_is_not_what_the_formula_says_is_found(
    make: Callable[..., Config], monkeypatch: pytest.MonkeyPatch
):
    """Negative control."""

    def brighter(value: float) -> Extreme:
        extreme = lamp_over_floor(scale=value)
        return replace(extreme, expected=1.01 * extreme.expected)

    wrong = Hazard("scale", "scale", "lamp-over-floor", "scale", brighter)
    monkeypatch.setattr("harness.stability.sweeps.HAZARDS", (wrong,))
    record = json.loads(measure_sweeps(make(["haste-cpu"], {"scale": [1.0]}), 1).read_text())
    for row in record["rows"]:
        assert row["error"]["upper"] < -5e-3, row


def row(tracer: str, precision: str, quantity: str, case: dict[str, object], **what: Any) -> Any:
    interval = Interval(*what.get("interval", (0.0, 0.0, 0.0)), what.get("n", 8))
    status, note = what.get("status", "ok"), what.get("note", "")
    names = (what.get("scene", "s"), tracer, "path", "depth_first", precision)
    return Measurement(*names, format_case(case), quantity, interval, "1", status, note)


def pushed(precision: str, values: dict[float, float]) -> list[Measurement]:
    return [
        row(
            "haste-cpu",
            precision,
            "closed_form_error",
            {"scale": value},
            interval=(error, error - 1e-5, error + 1e-5),
        )
        for value, error in values.items()
    ]


def cell(values: dict[float, float]) -> Any:
    curves = find_curves(Measurements(pushed("watertight", values)))
    line = next(line for line in LINES if line.name == "scale")
    return held(line, curves["scale"]["haste-cpu", "watertight"])


def test_a_cell_has_the_last_value_that_holds_on_either_side():
    decades = {10.0**power: 0.0 for power in range(-6, 7)}
    assert (cell(decades).kind, cell(decades).text) == ("pass", "10⁻⁶ … 10⁶")
    broken = cell({**decades, 1e4: 0.5, 1e-3: -0.1})
    assert (broken.kind, broken.text) == ("wait", "10⁻² … 10³")
    assert broken.note == "first not held: 10⁻³"
    assert cell({**decades, 1.0: 0.5}).kind == "fail"
    assert cell({1.0: 0.00099999}).text == "unsure", "its interval ends beyond the tolerance"


def test_a_hole_between_values_that_hold_ends_what_is_held():
    assert cell({1.0: 0.0, 10.0: 0.1, 100.0: 0.0}).text == "1"


def test_values_that_could_not_be_measured_are_no_success():
    gone = [
        row(
            *("mitsuba-scalar", "native", "closed_form_error", {"samples": 8}),
            interval=(math.nan,) * 3,
            status="skipped",
            note="too many",
        )
    ]
    matrix = make_stability_matrix(find_curves(Measurements([*pushed("fast", {1.0: 0.0}), *gone])))
    assert matrix is not None and matrix.tracers == [("haste-cpu", ["fast"])]
    failed = row(
        *("haste-cpu", "fast", "closed_form_error", {"triangles": KINDS[1]}),
        interval=(math.nan,) * 3,
        status="failed",
        note="3 of 4 samples are not finite",
    )
    curves = find_curves(Measurements([failed]))
    line = next(line for line in LINES if line.name == "triangles")
    assert held(line, curves["triangles"]["haste-cpu", "fast"]).text == "not duplicate"
    assert held(line, Curve()).kind == "" and Point(1.0, "fail").reason == ""


def test_what_was_measured_is_drawn_and_said():
    rows = pushed("watertight", {1e-6: 1e-7, 1.0: 0.0, 1e6: 1e-2})
    rows += [
        row("haste-cpu", "fast", "cracks_ppm", {"aim": "edge", "scale": 1.0, "eye": 1.0}, n=1000),
        row("haste-cpu", "fast", "paired_bias", {"against": "fp64"}, interval=(2e-6, 1e-6, 3e-6)),
        row("haste-cpu", "fast", "paired_speed", {"against": "fp64"}, interval=(1.5,) * 3),
        row("haste-cpu", "watertight", "paired_speed", {"against": "fp64"}, interval=(1.25,) * 3),
    ]
    measurements = Measurements(rows)
    curves = find_curves(measurements)
    assert plot_family(curves, "places") is not None and plot_family(curves, "lights") is None
    (line,) = trade_lines(measurements)
    assert "1.20 times" in line and "2.0 ppm [1.0, 3.0]" in line
    table = trade_table(measurements)
    assert table is not None and list(table.frame["precision"]) == ["fast"]
    assert trade_table(Measurements([])) is None


@pytest.mark.parametrize(
    ("value", "text"), [(1e-6, "10⁻⁶"), (1.0, "1"), (10.0, "10"), (1e8, "10⁸"), (3e-6, "3e-06")]
)
def test_powers_of_ten_are_written_as_such(value: float, text: str):
    assert power(value) == text


def test_every_hazard_has_a_line_and_a_case():
    names = {line.name for line in LINES}
    for hazard in HAZARDS:
        assert hazard.name in names
        assert format_case(hazard.case(1.0))
    assert SweepsJob({"provenance": {}}).run == "unnamed"
