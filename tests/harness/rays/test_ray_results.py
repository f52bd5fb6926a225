"""From records of rays to tables and report: every number in its row, every reason shown."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from harness.rays.classes import CLASSES
from harness.report.rays import find_ray_rows, geometric_mean, optix_note, ratio_table
from harness.report.write import write_report
from harness.tables import ResultsError, write_tables
from harness.tables.lookup import read_measurements
from harness.tables.rays import read_ray_jobs

RATES = {
    ("haste-cuda", "bvh2"): 4e9,
    ("haste-cpu", "bvh2"): 2e6,
    ("haste-cpu", "bvh8"): 4e6,
    ("embree", "intersect1"): 8e6,
    ("mitsuba-cuda", ""): 1e9,
}
SIZES = {"bumpy-16k": 16_384, "skull": 37_850}
COUNT = 4096


def variant(tracer: str, traversal: str, **what: Any) -> dict[str, Any]:
    own = tracer.startswith("haste")
    rate = RATES.get((tracer, traversal), 1.0)
    return {
        "tracer": tracer,
        "traversal": traversal,
        "precision": "watertight" if own else "robust" if tracer == "embree" else "native",
        "status": "ok",
        "reason": "",
        "rays": COUNT,
        "seconds": [COUNT / rate * (1.0 + 0.01 * (k - 2)) for k in range(5)],
        "visits": {"nodes": 11.0, "triangles": 3.5} if own else None,
        "structure": {"build_seconds": 0.25, "size": 64.0 * SIZES["skull"]} if own else None,
        "peak_bytes": 2**28,
        "joules": 0.125 if tracer == "haste-cuda" else None,
        "energy_reason": "traces on the processor" if tracer == "haste-cpu" else "",
        "wrong": {"count": 1, "rays": 1000},
        "differing": {"embree": {"count": 2, "rays": COUNT}} if own else {},
        **what,
    }


def absent(tracer: str, traversal: str, reason: str) -> dict[str, Any]:
    nothing = dict.fromkeys(("visits", "structure", "peak_bytes", "joules"))
    row = variant(tracer, traversal, status="skipped", reason=reason, seconds=[], rays=0, **nothing)
    return {name: row[name] for name in row if name not in {"wrong", "differing"}}


def add_rays(folder: Path, gpu: str = "NVIDIA H100 80GB HBM3") -> Path:
    """Add the benchmark of rays of two scenes to the files of a run."""
    (folder / "settings.json").write_text(
        json.dumps({"scenes": ["cornell-box"], "rays": {"scenes": list(SIZES)}})
    )
    for name, size in SIZES.items():
        rays = folder / "rays" / name
        rays.mkdir(parents=True)
        rows = [variant(*key) for key in RATES]
        rows.append(absent("embree", "intersect8", "no packets here"))
        rows.append(variant("mitsuba-scalar", "", seconds=[]))
        for one, any_hit in CLASSES.items():
            record = {"rays": one, "any_hit": any_hit, "count": COUNT, "variants": rows}
            record |= {"sample": 1000, "ambiguous": 3}
            (rays / f"{one}.json").write_text(json.dumps(record))
        description = {"name": name, "title": name, "triangles": size, "spheres": 0}
        (rays / "scene.json").write_text(json.dumps({**description, "classes": list(CLASSES)}))
        provenance = {"run": "fabricated", "machine": {"gpus": [{"name": gpu}]}}
        about = {**provenance, "rays": {"sha256": "ab" * 32, "count": COUNT}}
        (rays / "provenance.json").write_text(json.dumps(about))
    return folder


@pytest.fixture
def results(fabricate_results: Callable[..., Path]) -> Path:
    return add_rays(fabricate_results(scenes=("cornell-box",), models=("path",)))


@pytest.fixture
def measured(results: Path) -> pd.DataFrame:
    write_tables(results)
    rows = pd.read_csv(results / "measurements.csv", keep_default_na=False)
    return rows[rows.engine == "replay"]


def one(rows: pd.DataFrame, **columns: str) -> pd.Series:
    for name, value in columns.items():
        rows = rows[rows[name] == value]
    assert len(rows) == 1, rows
    return rows.iloc[0]


def test_every_quantity_is_a_row_with_its_case(measured: pd.DataFrame):
    where = {"scene": "skull", "tracer": "haste-cpu", "case": "rays=diffuse1;traversal=bvh8"}
    rate = one(measured, quantity="rays_per_second", **where)
    assert float(rate.value) == pytest.approx(4e6) and rate.n == 5
    assert float(rate.lower) < 4e6 < float(rate.upper) and rate.unit == "rays/s"
    assert rate.model == "none" and rate.precision == "watertight"
    for quantity, value in (
        ("nodes_per_ray", 11.0),
        ("triangles_per_ray", 3.5),
        ("disagreement_ppm", 1000.0),
        ("ambiguous_ppm", 3000.0),
    ):
        assert float(one(measured, quantity=quantity, **where).value) == value, quantity
    apart = one(
        measured,
        quantity="disagreement_ppm",
        **{**where, "case": "rays=diffuse1;to=embree;traversal=bvh8"},
    )
    assert float(apart.value) == pytest.approx(1e6 * 2 / COUNT) and apart.n == COUNT
    once = {**where, "case": "traversal=bvh8"}
    assert float(one(measured, quantity="build_seconds", **once).value) == 0.25
    assert float(one(measured, quantity="bytes_per_triangle", **once).value) == 64.0
    assert float(one(measured, quantity="peak_bytes", **once).value) == 2**28
    joules = one(
        measured,
        quantity="joules",
        scene="skull",
        tracer="haste-cuda",
        case="rays=camera;traversal=bvh2",
    )
    assert float(joules.value) == 0.125 and joules.unit == "J"


def test_what_is_missing_is_a_skipped_row_with_its_reason(measured: pd.DataFrame):
    where = {"scene": "skull", "quantity": "rays_per_second"}
    packets = one(measured, tracer="embree", case="rays=camera;traversal=intersect8", **where)
    assert (packets.status, packets.note, packets.value) == ("skipped", "no packets here", "")
    scalar = one(measured, tracer="mitsuba-scalar", case="rays=camera", **where)
    assert scalar.status == "skipped" and "one ray a call" in scalar.note
    joules = one(
        measured,
        scene="skull",
        quantity="joules",
        tracer="haste-cpu",
        case="rays=camera;traversal=bvh2",
    )
    assert (joules.status, joules.note) == ("skipped", "traces on the processor")


def test_ratios_are_of_rays_a_second_over_the_first_way_of_a_tracer(measured: pd.DataFrame):
    ratio = one(
        measured,
        scene="bumpy-16k",
        quantity="speed_ratio",
        tracer="haste-cuda",
        case="rays=shuffled;to=mitsuba-cuda;traversal=bvh2",
    )
    assert float(ratio.value) == pytest.approx(4.0)
    assert float(ratio.lower) < 4.0 < float(ratio.upper)
    own = measured[(measured.tracer == "embree") & (measured.quantity == "speed_ratio")]
    assert not own.case.str.contains("to=embree").any()


def test_every_repeat_is_a_sample(results: Path, measured: pd.DataFrame):
    del measured
    samples = pd.read_parquet(results / "samples.parquet")
    rays = samples[(samples.engine == "replay") & (samples.tracer == "haste-cuda")]
    assert len(rays) == 5 * len(CLASSES) * len(SIZES)
    assert set(rays.quantity) == {"rays_per_second"} and set(rays.seed) == set(range(5))


def test_the_report_shows_rates_ratios_tests_and_reasons(results: Path):
    write_tables(results)
    text = write_report(results).read_text()
    assert '<section id="rays">' in text and '<a href="#rays">' in text
    assert "OptiX through Mitsuba, no RT cores on this GPU" in text
    assert "no packets here" in text
    for name in ("rays-embree", "rays-mitsuba-cuda", "ray-tests"):
        assert (results / "figures" / f"{name}.svg").is_file(), name
    captions = re.findall(r"<figcaption>(Rays a second .*?)</figcaption>", text)
    assert len(captions) == 2
    assert all("OptiX through Mitsuba, no RT cores on this GPU" in one for one in captions)
    names = {path.stem for path in (results / "tables").iterdir()}
    assert {"rays", "ray_ratios", "ray_hierarchies", "rays_skipped"} <= names


def test_a_gpu_with_rt_cores_is_not_said_to_have_none(results: Path):
    assert "no RT cores" in optix_note(read_ray_jobs(results))
    for path in results.glob("rays/*/provenance.json"):
        path.write_text(path.read_text().replace("NVIDIA H100 80GB HBM3", "NVIDIA L40S"))
    assert optix_note(read_ray_jobs(results)) == "mitsuba-cuda: OptiX through Mitsuba."
    assert optix_note([]) == ""


def test_the_table_of_ratios_has_geometric_means_over_scenes(results: Path):
    write_tables(results)
    table = ratio_table(find_ray_rows(read_measurements(results / "measurements.csv")))
    assert table is not None
    frame = table.frame.set_index(["to", "tracer", "way"])
    assert frame.loc[("embree", "haste-cpu", "bvh8"), "diffuse1"] == pytest.approx(0.5)
    assert frame.loc[("mitsuba-cuda", "haste-cuda", "bvh2"), "camera"] == pytest.approx(4.0)
    assert frame.loc[("embree", "haste-cpu", "bvh8"), "scenes"] == 2
    assert geometric_mean([1.0, 4.0]) == pytest.approx(2.0)


def test_a_run_without_rays_has_no_section_of_them(written_report: Path):
    assert '<section id="rays">' not in written_report.read_text()


def test_a_class_without_a_record_is_an_error_that_names_the_file(results: Path):
    (results / "rays" / "skull" / "camera.json").unlink()
    with pytest.raises(ResultsError, match=r"rays/skull/camera\.json: cannot be read"):
        write_tables(results)
