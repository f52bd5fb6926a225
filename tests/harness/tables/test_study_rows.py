"""Rows of the study of packets, from fabricated renders whose law is known."""

from pathlib import Path

import pytest
from fabricated_study import FLOAT_GAIN, KINK, LAWS, QUEUED, RAYS, REALLOCATION, fabricate_study

from harness.tables.schema import Recorder
from harness.tables.study import read_study, record_study


@pytest.fixture(scope="module")
def recorder(tmp_path_factory: pytest.TempPathFactory) -> Recorder:
    folder = tmp_path_factory.mktemp("study")
    fabricate_study(folder, {"skull": ["haste"]}, elsewhere=("cornell-box",), noise=0.01)
    recorder = Recorder()
    for job in read_study(folder):
        record_study(recorder, job)
    return recorder


def values(
    recorder: Recorder, quantity: str, *, scene: str = "skull", **more: object
) -> dict[tuple[str, str], dict]:
    return {
        (str(row["engine"]), str(row["case"])): row
        for row in recorder.measurements
        if row["quantity"] == quantity
        and row["scene"] == scene
        and row["status"] == "ok"
        and all(row[key] == value for key, value in more.items())
    }


def test_each_engine_has_its_law_back(recorder: Recorder):
    empty, rate = (values(recorder, name) for name in ("launch_seconds", "r_inf"))
    for (engine, case), row in rate.items():
        if engine == "layers" or "per_packet" in case:
            continue
        expected = LAWS[engine]
        assert row["value"] == pytest.approx(expected[1], rel=0.03), (engine, case, row)
        found = empty[engine, case]["value"]
        assert found == pytest.approx(expected[0], rel=0.05), (engine, case, found)


def test_allocating_for_each_packet_is_in_the_empty_launch(recorder: Recorder):
    empty = values(recorder, "launch_seconds")
    found = empty["packets", "allocation=per_packet;light_samples=4;order=fifo"]["value"]
    assert found == pytest.approx(LAWS["packets"][0] + REALLOCATION, rel=0.05)


def test_the_engine_with_a_kink_and_no_other_is_said_to_have_one(recorder: Recorder):
    kinks = values(recorder, "law_kink_rays")
    assert {engine for engine, _ in kinks} == {"layers"}, kinks
    (row,) = kinks.values()
    assert KINK / 4 <= row["value"] <= KINK * 4
    (ratio,) = values(recorder, "law_kink_ratio").values()
    assert ratio["value"] == pytest.approx(2.0, rel=0.1)


def test_few_sizes_have_no_law_and_say_so(recorder: Recorder):
    rows = [
        row
        for row in recorder.measurements
        if row["scene"] == "cornell-box" and row["quantity"] == "r_inf"
    ]
    assert rows and all(
        row["status"] == "skipped" and "5 sizes" in str(row["note"]) for row in rows
    )


@pytest.mark.parametrize("scene", ["skull", "cornell-box"])
def test_prices_are_ratios_with_intervals_on_every_scene(recorder: Recorder, scene: str):
    films = values(recorder, "determinism_price", scene=scene)
    assert {engine for engine, _ in films} == set(LAWS)
    for key, row in films.items():
        assert row["lower"] <= 1.0 / FLOAT_GAIN <= row["upper"] or row["value"] == pytest.approx(
            1.0 / FLOAT_GAIN, rel=0.03
        ), (key, row)
    allocations = values(recorder, "reallocation_price", scene=scene)
    for (_, case), row in allocations.items():
        packet = int(case.split("packet=")[1])
        own = LAWS["packets"][0] + packet / LAWS["packets"][1]
        expected = 1.0 + (REALLOCATION + 1.5e-9 * packet) / own
        assert row["value"] == pytest.approx(expected, rel=0.05), (case, row)


def test_rates_of_the_queue_and_of_all_rays_are_told_apart(recorder: Recorder):
    rates = values(recorder, "rays_per_second")
    case = "light_samples=4;packet=65536;rays="
    queued, every = (rates["wavefront", case + kind]["value"] for kind in ("queued", "all"))
    assert every / queued == pytest.approx(sum(RAYS.values()) / QUEUED)


def test_a_full_packet_has_a_fill_of_one(recorder: Recorder):
    fills = values(recorder, "packet_fill")
    assert fills and all(row["value"] == pytest.approx(1.0) for row in fills.values())


def test_studies_do_not_touch_the_rows_of_other_sweeps(recorder: Recorder):
    assert all(
        "light_samples=4" in str(row["case"]) or row["quantity"] == "copy_rate"
        for row in recorder.measurements
    )


def test_a_folder_without_a_study_has_no_rows(tmp_path: Path):
    assert read_study(tmp_path) == []
