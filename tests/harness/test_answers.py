"""Known answers judged on fabricated results: verdicts, exit codes, rows, the report's section."""

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.answers import (
    DELTA,
    judge_answers,
    judge_error,
)
from harness.gate import check, worst_code
from harness.measure.answers import expected_answers
from harness.report.write import write_report
from harness.scene import load_scene, load_settings
from harness.statistics.bias import Verdict, exit_code_of
from harness.statistics.intervals import Interval
from harness.tables import read_jobs, write_tables
from reference.analytic import AnswerError

Fabricate = Callable[..., Path]
SHARP = {"scenes": ("cornell-box",), "models": ("path",), "size": 16, "spp": 4096, "seeds": 16}
SCENES = Path(__file__).parents[2] / "scenes" / "analytic"


def with_answer(folder: Path, factor: float = 1.0) -> Path:
    """Give the fabricated scene a known answer: the mean of its truth, times a factor."""
    scene = folder / "scenes" / "cornell-box"
    batches = [np.load(path) for path in sorted(scene.glob("truth/path/batch_*.npy"))]
    mean = np.mean(batches, axis=(0, 1, 2))
    description = json.loads((scene / "scene.json").read_text())
    description["settings"] = {"answer": "sphere_light"}
    description["answers"] = {"path": [float(value * factor) for value in mean]}
    (scene / "scene.json").write_text(json.dumps(description))
    return folder


def test_a_known_answer_passes_for_every_tracer_and_the_truth(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = with_answer(fabricate_results(**SHARP))
    assert check(folder) == 0
    out = capsys.readouterr().out
    for tracer in ("truth", "haste-cpu", "embree", "mitsuba-llvm"):
        (line,) = [row for row in out.splitlines() if f"{tracer} " in row and "answer" in row]
        assert line.startswith("PASS"), line
    assert "known answers: 4 pass, 0 fail, 0 not enough samples" in out


@pytest.mark.parametrize("factor", [0.995, 1.005])
def test_an_answer_that_is_half_a_per_cent_off_fails_the_gate(
    factor: float, fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = with_answer(fabricate_results(**SHARP), factor)
    assert check(folder) == 1
    out = capsys.readouterr().out
    assert "known answers: 0 pass, 4 fail, 0 not enough samples" in out, out


def test_one_tracer_that_is_off_fails_alone(fabricate_results: Fabricate):
    changed = fabricate_results(**SHARP, changes={"embree": lambda image: 1.004 * image})
    verdicts = {row.tracer: row.verdict for row in judge_answers(read_jobs(with_answer(changed)))}
    assert verdicts.pop("embree") is Verdict.FAIL
    assert set(verdicts.values()) == {Verdict.PASS}, verdicts


def test_too_few_samples_of_a_known_answer_are_no_pass(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = with_answer(fabricate_results(**SHARP | {"spp": 16, "seeds": 4}))
    verdicts = judge_answers(read_jobs(folder))
    assert exit_code_of(row.verdict for row in verdicts) == 2
    check(folder)
    assert "images)" in capsys.readouterr().out


def test_pixels_that_are_not_finite_fail(fabricate_results: Fabricate):
    folder = with_answer(fabricate_results(**SHARP))
    path = folder / "scenes/cornell-box/seeds/path/embree/seed_002.npy"
    image = np.load(path)
    image[0, 0, 0] = np.nan
    np.save(path, image)
    (row,) = [row for row in judge_answers(read_jobs(folder)) if row.tracer == "embree"]
    assert row.verdict is Verdict.FAIL
    assert row.note == "pixels are not finite"


def test_an_answer_needs_no_truth(fabricate_results: Fabricate):
    folder = with_answer(fabricate_results(**SHARP))
    scene = folder / "scenes" / "cornell-box"
    shutil.rmtree(scene / "truth")
    skipped = [{"model": "path", "reason": "no LLVM library"}]
    (scene / "truth.json").write_text(json.dumps({"skipped": skipped}))
    verdicts = {row.tracer: row.verdict for row in judge_answers(read_jobs(folder))}
    assert list(verdicts) == ["haste-cpu", "embree", "mitsuba-llvm"]
    assert set(verdicts.values()) == {Verdict.PASS}, verdicts


def test_a_scene_that_lost_its_answers_is_an_error(
    fabricate_results: Fabricate, capsys: pytest.CaptureFixture[str]
):
    folder = with_answer(fabricate_results(**SHARP))
    file = folder / "scenes/cornell-box/scene.json"
    description = json.loads(file.read_text())
    del description["answers"]
    file.write_text(json.dumps(description))
    assert check(folder) == 1
    assert f"{file}: the scene's known answers are missing" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("lower", "upper", "verdict"),
    [
        (-0.9, 0.9, Verdict.PASS),
        (-0.9, 1.1, Verdict.NOT_ENOUGH_SAMPLES),
        (-1.1, 1.1, Verdict.NOT_ENOUGH_SAMPLES),
        (1.1, 1.2, Verdict.FAIL),
        (-1.2, -1.1, Verdict.FAIL),
        (float("nan"), float("nan"), Verdict.NOT_ENOUGH_SAMPLES),
    ],
)
def test_the_verdict_of_an_interval(lower: float, upper: float, verdict: Verdict):
    error = Interval(0.5 * DELTA, lower * DELTA, upper * DELTA, 16)
    assert judge_error(error) is verdict, error


def test_a_failure_outweighs_missing_samples():
    assert worst_code(0, 2) == 2
    assert worst_code(2, 1, 0) == 1
    assert worst_code(0, 0) == 0


def test_both_quantities_are_rows_of_the_table(fabricate_results: Fabricate):
    folder = with_answer(fabricate_results(**SHARP))
    write_tables(folder)
    with (folder / "measurements.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["quantity"].startswith("answer")]
    cases = {(row["tracer"], row["quantity"]): row["case"] for row in rows}
    tracers = ("truth", "haste-cpu", "embree", "mitsuba-llvm")
    assert cases == {
        (tracer, quantity): case
        for tracer in tracers
        for quantity, case in (("answer", ""), ("answer_error", "level=0.99"))
    }


def test_the_report_shows_known_answers_where_there_are_any(fabricate_results: Fabricate):
    folder = fabricate_results(**SHARP)
    write_tables(folder)
    assert '<section id="answers">' not in write_report(folder).read_text()
    assert not (folder / "tables" / "answers.csv").exists()
    with_answer(folder)
    write_tables(folder)
    page = write_report(folder).read_text()
    section = page[page.index('<section id="answers">') :]
    section = section[: section.index("</section>")]
    assert section.count('class="badge pass"') == 4
    assert (folder / "figures" / "answers.svg").is_file()
    with (folder / "tables" / "answers.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["tracer"] for row in rows] == ["truth", "haste-cpu", "embree", "mitsuba-llvm"]
    assert {row["verdict"] for row in rows} == {"PASS"}


def test_a_job_writes_the_answers_of_its_scene():
    folder = SCENES / "sphere-light"
    settings = load_settings(folder)
    renders = {model: settings.render(model) for model in settings.models}
    found = expected_answers(settings.answer, load_scene(folder), renders)
    assert list(found) == ["path", "haste", "whitted"]
    assert found["path"] == pytest.approx((0.3, 0.225, 0.12), rel=1e-6)
    assert expected_answers("", load_scene(folder), renders) == {}


def test_a_model_that_has_no_answer_cannot_be_claimed():
    folder = SCENES / "wall-sky"
    settings = load_settings(folder)
    with pytest.raises(AnswerError, match="wall-sky: wall_sky has no answer in the model haste"):
        expected_answers(settings.answer, load_scene(folder), {"haste": settings.render("haste")})
