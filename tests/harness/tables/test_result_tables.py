"""The two tables: closed lists, columns, and values that the files imply."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from harness.statistics.intervals import Interval
from harness.statistics.spectrum import error_spectra
from harness.tables import ResultsError, SchemaError, format_case, parse_case, write_tables
from harness.tables.lookup import Measurements, read_measurements
from harness.tables.read import read_jobs
from harness.tables.schema import Recorder, Subject, load_list

SUBJECT = Subject("run", "scene", "embree", "path", "depth_first", "robust")


@pytest.fixture(scope="module")
def measurements(written_results: Path) -> Measurements:
    return read_measurements(written_results / "measurements.csv")


def test_both_tables_have_exactly_the_columns_of_their_schemas(written_results: Path):
    frames = {
        "samples": pd.read_parquet(written_results / "samples.parquet"),
        "measurements": pd.read_csv(written_results / "measurements.csv", keep_default_na=False),
    }
    for name, frame in frames.items():
        assert list(frame.columns) == list(load_list(name)), name
        assert set(frame["quantity"]) <= set(load_list("quantities")), name
        assert set(frame["status"]) <= {"ok", "skipped", "failed"}, name


def test_no_measurement_occurs_twice(written_results: Path):
    frame = pd.read_csv(written_results / "measurements.csv", keep_default_na=False)
    keys = ["run", "scene", "tracer", "model", "engine", "precision", "case", "quantity"]
    repeated = frame[frame.duplicated(keys, keep=False)]
    assert repeated.empty, repeated


def test_a_skipped_tracer_is_a_row_with_its_reason(written_results: Path):
    frame = pd.read_csv(written_results / "measurements.csv")
    rows = frame[(frame.tracer == "haste-cuda") & (frame.model == "whitted")]
    assert list(rows.status) == ["skipped", "skipped"]
    assert set(rows.note) == {"no NVIDIA driver: libcuda.so.1 cannot be opened"}
    assert rows.value.isna().all()


def test_rates_follow_from_seconds_and_counts(measurements: Measurements):
    where = {"scene": "cornell-box", "model": "haste", "tracer": "haste-cpu"}
    samples = measurements.find("samples_per_second", **where)
    rays = measurements.find("rays_per_second", case="rays=all", **where)
    assert samples is not None
    assert rays is not None
    # One camera, three shadow, four ambient and two bounce rays a sample.
    assert rays.value == pytest.approx(10.0 * samples.value, rel=1e-6)
    assert samples.lower < 4e5 < samples.upper
    per_sample = measurements.find("rays_per_sample", case="rays=ambient", **where)
    assert per_sample is not None
    assert per_sample.value == 4.0


def test_ratios_are_above_one_for_the_faster_tracer(measurements: Measurements):
    ratio = measurements.find(
        "speed_ratio", scene="cornell-box", model="path", tracer="embree", case="to=mitsuba-llvm"
    )
    assert ratio is not None
    assert ratio.lower < 1.2 < ratio.upper


def test_the_sweep_of_packets_is_complete(measurements: Measurements):
    for order in ("fifo", "lifo"):
        found = measurements.sweep(
            "rays_per_second",
            "packet",
            scene="cornell-box",
            model="haste",
            tracer="haste-cpu",
            engine="packets",
            order=order,
            rays="all",
        )
        assert list(found) == [2**k for k in range(4, 21)]


def test_convergence_is_of_first_order(measurements: Measurements):
    for model in ("path", "haste"):
        slope = measurements.find("slope", scene="cornell-box", model=model, tracer="embree")
        assert slope is not None
        assert slope.lower < -0.98 < slope.upper or -1.02 < slope.value < -0.98, slope


def test_the_spectrum_of_a_tracers_images_is_a_row_at_every_frequency(written_results: Path):
    frame = pd.read_csv(written_results / "measurements.csv")
    frame = frame[(frame.scene == "cornell-box") & (frame.tracer == "embree")]
    powers = frame[frame.quantity == "error_power"]
    assert set(powers.model) == {"path"}
    # Rings of 32 x 32 pixels are one cycle wide and end at half a cycle a pixel.
    assert [parse_case(case)["frequency"] for case in powers.case] == [k / 32 for k in range(1, 17)]
    (job,) = [job for job in read_jobs(written_results) if job.name == "cornell-box"]
    images = job.seeds("path", "embree")
    assert images is not None
    spectra = error_spectra(images.images.astype(np.float64), job.truth("path"))
    np.testing.assert_allclose(powers.value, spectra.mean(axis=0), rtol=1e-8)
    assert ((powers.lower < powers.value) & (powers.value < powers.upper)).all()
    runs = frame[frame.quantity == "error_power_run"]
    cases = [parse_case(case) for case in runs.case]
    assert [case["quantile"] for case in cases] == [0.1, 0.9] * 16
    # With eight runs these are the second and the last but one by their error.
    order = np.argsort(spectra.mean(axis=1))
    np.testing.assert_allclose(runs.value[::2], spectra[order[1]], rtol=1e-8)
    np.testing.assert_allclose(runs.value[1::2], spectra[order[-2]], rtol=1e-8)


def test_three_images_have_no_spectrum(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("path",), seeds=3)
    write_tables(folder)
    assert not set(pd.read_csv(folder / "measurements.csv").quantity) & {"error_power"}


def test_time_to_unit_variance_is_variance_times_seconds(measurements: Measurements):
    where = {"scene": "cornell-box", "model": "path", "tracer": "embree"}
    variance = measurements.find("variance", case="seeds=8;spp=64", **where)
    seconds = measurements.find("seconds", case="spp=64", **where)
    ttuv = measurements.find("ttuv_seconds", **where)
    assert variance is not None
    assert seconds is not None
    assert ttuv is not None
    assert ttuv.value == pytest.approx(variance.value * seconds.value, rel=0.03)


def test_the_provenance_is_shared_where_scenes_agree(written_results: Path):
    provenance = json.loads((written_results / "provenance.json").read_text())
    assert provenance["run"] == "fabricated"
    assert provenance["machine"]["cores"] == 2
    assert set(provenance["scenes"]) == {"cornell-box", "mirror-glass"}
    assert provenance["scenes"]["cornell-box"]["scene"]["name"] == "cornell-box"


def test_writing_twice_gives_the_same_bytes(written_results: Path):
    names = ("measurements.csv", "provenance.json")
    before = [(written_results / name).read_bytes() for name in names]
    write_tables(written_results)
    assert [(written_results / name).read_bytes() for name in names] == before


def test_an_unknown_quantity_is_refused():
    with pytest.raises(SchemaError, match=r"unknown quantity 'raysps'.*quantities\.yaml"):
        Recorder().measure(SUBJECT, "raysps", Interval(1.0, 1.0, 1.0, 2))


@pytest.mark.parametrize(
    ("case", "message"),
    [
        ({"depth": 3}, "unknown key 'depth'"),
        ({"order": "random"}, "expected one of fifo, lifo"),
        ({"packet": "64"}, "expected a value of type integer"),
        ({"packet": True}, "expected a value of type integer"),
    ],
)
def test_an_unknown_case_is_refused(case: dict[str, object], message: str):
    with pytest.raises(SchemaError, match=message):
        format_case(case)


def test_a_case_is_sorted_and_reads_back():
    case = {"packet": 65536, "order": "lifo"}
    assert format_case(case) == "order=lifo;packet=65536"
    assert parse_case(format_case(case)) == case
    assert parse_case("") == {}


@pytest.mark.parametrize(
    ("columns", "interval", "message"),
    [
        ({"model": "phong"}, (1.0, 1.0, 1.0), r"measurements\.model: 'phong' is not one of path, "),
        ({"engine": "queue"}, (1.0, 1.0, 1.0), r"measurements\.engine: 'queue' is not one of"),
        ({"scene": 3}, (1.0, 1.0, 1.0), r"measurements\.scene: 3 is not of type string"),
        ({}, (float("nan"),) * 3, r"measurements\.value: a row of status ok has none"),
        ({}, (2.0, 0.0, 1.0), r"measurements\.value: 2 is not within 0 and 1"),
    ],
)
def test_a_row_outside_the_schema_is_refused_by_its_column(
    columns: dict[str, Any], interval: tuple[float, float, float], message: str
):
    subject = replace(SUBJECT, **columns)
    with pytest.raises(SchemaError, match=message):
        Recorder().measure(subject, "slope", Interval(*interval, 2))


def test_a_failure_without_a_reason_is_refused():
    with pytest.raises(SchemaError, match=r"measurements\.note: .* needs the reason"):
        Recorder().measure(SUBJECT, "slope", Interval(1.0, 1.0, 1.0, 2), status="failed")


def test_an_unknown_number_among_the_times_is_refused(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    path = folder / "scenes/cornell-box/timing.json"
    rows = json.loads(path.read_text())
    rows[0]["furlongs"] = 3.0
    path.write_text(json.dumps(rows))
    with pytest.raises(SchemaError, match=r"embree|haste-cpu.*'furlongs'"):
        write_tables(folder)


def test_a_tracer_that_failed_half_way_measures_nothing(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    path = folder / "scenes/cornell-box/skipped.json"
    rows = json.loads(path.read_text())
    rows.append({"tracer": "embree", "model": "whitted", "status": "failed", "reason": "died"})
    path.write_text(json.dumps(rows))
    write_tables(folder)
    frame = pd.read_csv(folder / "measurements.csv")
    (found,) = frame[(frame.tracer == "embree") & (frame.quantity == "relative_bias")].itertuples()
    assert (found.status, found.note) == ("failed", "died")


def test_images_in_which_nothing_varies_say_so(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    images = folder / "scenes/cornell-box/seeds/whitted/embree"
    np.save(images / "seed_001.npy", np.load(images / "seed_000.npy"))
    write_tables(folder)
    frame = pd.read_csv(folder / "measurements.csv")
    here = (frame.tracer == "embree") & (frame.quantity == "effective_pixels")
    (found,) = frame[here].itertuples()
    assert (found.status, found.note) == ("skipped", "nothing varies")


def test_a_damaged_image_is_named(fabricate_results: Callable[..., Path]):
    folder = fabricate_results(scenes=("cornell-box",), models=("whitted",), seeds=2)
    path = folder / "scenes/cornell-box/seeds/whitted/embree/seed_001.npy"
    np.save(path, np.zeros((3, 3, 3), np.float32))
    with pytest.raises(ResultsError, match=r"seed_001\.npy: shape \(3, 3, 3\)"):
        write_tables(folder)
    path.write_bytes(b"no array")
    with pytest.raises(ResultsError, match=r"seed_001\.npy: not a NumPy array"):
        write_tables(folder)


def test_a_folder_without_scenes_is_named(tmp_path: Path):
    with pytest.raises(ResultsError, match="no scene job"):
        write_tables(tmp_path)
