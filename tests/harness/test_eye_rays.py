"""Eye rays: which rays they are, what counts as a difference, and what a run makes of them."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from harness.eye_rays import (
    ALLOWED_PPM,
    EyeRayVerdict,
    NoEyeRays,
    Seen,
    corner_rays,
    count_differences,
    judge_eye_rays,
)
from harness.gate import check
from harness.report.write import write_report
from harness.scene import Camera
from harness.tables import ResultsError, write_tables
from harness.tracers.rays import NONE

CAMERA = Camera(
    origin=(1.0, 2.0, 3.0),
    corner=(-0.5, 0.25, -1.0),
    dx=(0.25, 0.0, 0.0),
    dy=(0.0, -0.25, 0.0),
    near=0.5,
    width=4,
    height=2,
)
RAYS = 263_169
VERDICT = EyeRayVerdict("tetra", "embree", 49_949, RAYS, 49_788, 0.01, 0, {"haste-cpu": 0})


def test_eye_rays_go_through_every_corner_of_a_pixel_from_the_near_plane():
    origins, directions = corner_rays(CAMERA)
    assert origins.shape == directions.shape == (5 * 3, 3)
    assert origins.dtype == directions.dtype == np.float32
    for index, (x, y) in enumerate((x, y) for y in range(3) for x in range(5)):
        through = np.array([-0.5 + 0.25 * x, 0.25 - 0.25 * y, -1.0])
        np.testing.assert_allclose(origins[index], [1, 2, 3] + 0.5 * through, rtol=1e-7)
        unit = through / np.linalg.norm(through)
        np.testing.assert_allclose(directions[index], unit, rtol=1e-7, atol=1e-9)


def seen(*hits: tuple[float, int]) -> Seen:
    t, primitive = zip(*hits, strict=True)
    return Seen(np.array(t, np.float32), np.array(primitive, np.uint32))


MISS = (np.inf, int(NONE))


@pytest.mark.parametrize(
    ("one", "other", "differ"),
    [
        ((2.0, 5), (2.0, 5), False),
        (MISS, MISS, False),
        ((2.0, 5), MISS, True),
        ((2.0, 5), (2.1, 6), True),
        ((2.0, 5), (2.0001, 6), False),
        ((2.0, 5), (2.1, 5), False),
        ((2.0, int(NONE)), (2.0001, 5), False),
        ((2.0, int(NONE)), (2.1, int(NONE)), True),
    ],
    ids=[
        "the same hit",
        "both miss",
        "one misses",
        "another surface",
        "a shared edge",
        "a grazed sphere",
        "a primitive that is not known",
        "an unknown primitive elsewhere",
    ],
)
def test_rays_differ_by_hit_or_by_primitive_and_distance(
    one: tuple[float, int], other: tuple[float, int], differ: bool
):
    for a, b in ((one, other), (other, one)):
        assert count_differences(seen(a, (1.0, 1)), seen(b, (1.0, 1))) == int(differ), (a, b)


def test_a_count_passes_within_its_share_and_no_further():
    allowed = int(0.01 * 49_788)
    for hits, passes in ((0, False), (49_788 - allowed, True), (49_788 + allowed, True)):
        assert replace(VERDICT, hits=hits).passed is passes, hits
    for hits in (49_788 - allowed - 1, 49_788 + allowed + 1):
        assert not replace(VERDICT, hits=hits).counted, hits


def test_a_few_rays_at_silhouettes_pass_and_a_few_more_fail():
    most = int(ALLOWED_PPM * 1e-6 * RAYS)
    assert replace(VERDICT, disagreeing=most, differing={"haste-cpu": most}).passed
    assert not replace(VERDICT, disagreeing=most + 1).passed
    assert not replace(VERDICT, differing={"haste-cpu": 0, "mitsuba-llvm": most + 1}).passed


def test_a_line_says_what_was_counted_and_who_differs_most():
    line = replace(
        VERDICT, disagreeing=2, differing={"haste-cpu": 1, "mitsuba-llvm": 40}
    ).describe()
    assert line.startswith("FAIL"), line
    for part in (
        "tetra eye rays embree",
        "49,949 of 263,169 rays hit, +0.32% of the published 49,788, within ±1%: PASS",
        "7.6 ppm differ from double precision, 152.0 ppm from mitsuba-llvm, at most 50: FAIL",
    ):
        assert part in line, line


def record(**changes: Any) -> dict[str, Any]:
    """A record of two tracers that agree and one that could not."""
    row = {"status": "ok", "hits": 49_949, "disagreeing": 0, "seconds": 0.02}
    return {
        "rays": RAYS,
        "published": 49_788,
        "share": 0.01,
        "order": ["haste-cuda", "haste-cpu", "embree"],
        "tracers": {
            "haste-cpu": {**row, "differing": {"embree": 0}},
            "embree": {**row, "differing": {"haste-cpu": 0}, **changes},
            "haste-cuda": {"status": "skipped", "reason": "no NVIDIA driver here"},
        },
    }


def test_verdicts_come_in_the_order_of_the_run():
    verdicts = judge_eye_rays("tetra", record())
    assert [row.tracer for row in verdicts] == ["haste-cuda", "haste-cpu", "embree"]
    assert [type(row) for row in verdicts] == [NoEyeRays, EyeRayVerdict, EyeRayVerdict]
    assert judge_eye_rays("tetra", None) == []


@pytest.fixture
def results(fabricate_results: Callable[..., Path]) -> Callable[..., Path]:
    """A run of one scene with eye rays; arguments change Embree's row."""

    def make(**changes: Any) -> Path:
        folder = fabricate_results(scenes=("cornell-box",), models=("path",), spp=256, seeds=16)
        file = folder / "scenes" / "cornell-box" / "eye_rays.json"
        file.write_text(json.dumps(record(**changes)))
        return folder

    return make


def test_the_gate_prints_a_line_a_tracer_and_passes(
    results: Callable[..., Path], capsys: pytest.CaptureFixture[str]
):
    code = check(results())
    lines = [line for line in capsys.readouterr().out.splitlines() if "eye rays" in line]
    assert [line.split()[0] for line in lines] == ["skipped", "PASS", "PASS"], lines
    assert code == 0, lines


@pytest.mark.parametrize(
    "fault",
    [
        {"hits": 51_000},
        {"disagreeing": 20},
        {"differing": {"haste-cpu": 20}},
        {"status": "failed", "reason": "its process died"},
    ],
    ids=lambda fault: next(iter(fault)),
)
def test_the_gate_fails_with_one_tracer(
    results: Callable[..., Path], capsys: pytest.CaptureFixture[str], fault: dict[str, Any]
):
    assert check(results(**fault)) == 1
    lines = [line for line in capsys.readouterr().out.splitlines() if "eye rays embree" in line]
    assert [line.split()[0] for line in lines] == ["FAIL"], lines


def test_counts_are_rows_of_the_table_of_measurements(results: Callable[..., Path]):
    folder = results(disagreeing=4, differing={"haste-cpu": 8})
    write_tables(folder)
    frame = pd.read_csv(folder / "measurements.csv", keep_default_na=False)
    rows = frame[frame.quantity.str.startswith("eye_rays")]
    assert set(rows.model) == {"none"} and set(rows.engine) == {"replay"}
    skipped = rows[rows.status == "skipped"]
    assert skipped[["tracer", "quantity", "note"]].to_numpy().tolist() == [
        ["haste-cuda", "eye_rays_hit", "no NVIDIA driver here"]
    ]
    embree = rows[rows.tracer == "embree"]
    found = {(row.quantity, row.case): float(row.value) for row in embree.itertuples()}
    assert found == {
        ("eye_rays_hit", ""): 49_949.0,
        ("eye_rays_published", ""): 49_788.0,
        ("eye_rays_disagreement_ppm", ""): pytest.approx(4e6 / RAYS),
        ("eye_rays_disagreement_ppm", "to=haste-cpu"): pytest.approx(8e6 / RAYS),
    }
    assert set(embree.n) == {RAYS}


def test_the_report_has_a_table_of_eye_rays_where_there_are_any(results: Callable[..., Path]):
    folder = results()
    write_tables(folder)
    page = write_report(folder).read_text()
    for part in ('id="eye-rays"', 'href="#eye-rays"', "49,949", "49,788", "no NVIDIA driver here"):
        assert part in page, part
    frame = pd.read_csv(folder / "tables" / "eye_rays.csv")
    assert frame.verdict.tolist() == ["skipped", "PASS", "PASS"]
    (folder / "scenes" / "cornell-box" / "eye_rays.json").unlink()
    assert 'id="eye-rays"' not in write_report(folder).read_text()


def test_a_damaged_record_is_named(
    results: Callable[..., Path], capsys: pytest.CaptureFixture[str]
):
    folder = results()
    (folder / "scenes" / "cornell-box" / "eye_rays.json").write_text("{")
    assert check(folder) == 1
    assert "eye_rays.json: not JSON" in capsys.readouterr().err
    with pytest.raises(ResultsError, match=r"eye_rays\.json: not JSON"):
        write_tables(folder)
