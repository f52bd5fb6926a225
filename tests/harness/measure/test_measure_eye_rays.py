"""Eye rays of a scene: what is written, what is kept, and who could not."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from harness.eye_rays import EyeRayVerdict, NoEyeRays, judge_eye_rays
from harness.measure.crew import Crew
from harness.measure.eye_rays import measure_eye_rays
from harness.tracers.haste import HasteCpu

REASON = HasteCpu.unavailable()
pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")

RAYS = 33 * 25
# Of the rays (x, y), x = 0 .. 32, y = 0 .. 24, those within the ball's outline: a cone of sine 1/5
# about the axis meets the film in a circle of radius tan(asin(1/5)) / tan(20 degrees) * 16 pixels.
INSIDE = sum(
    (x - 16.0) ** 2 + (y - 12.0) ** 2 < (16.0 / 24.0**0.5 / 0.3639702342662024) ** 2
    for x in range(33)
    for y in range(25)
)


@pytest.fixture
def ball(scene_path: Path) -> Path:
    """The scene of a ball of radius 1, seen from a distance of 5 on 32 x 24 pixels."""
    film = '<integer name="{}" value="{}"/>'
    text = scene_path.read_text()
    for side, size in (("width", 32), ("height", 24)):
        text = text.replace(film.format(side, 8), film.format(side, size))
    scene_path.write_text(text)
    publish(scene_path, INSIDE)
    return scene_path


def publish(scene_path: Path, hits: int) -> None:
    settings = f"models: [path]\neye_rays: {{hits: {hits}, share: 0.01}}\n"
    (scene_path.parent / "settings.yaml").write_text(settings)


@pytest.fixture
def crew() -> Iterator[Crew]:
    with Crew((), 1, 60.0) as crew:
        yield crew


def measured(crew: Crew, scene: Path, folder: Path, *tracers: str) -> dict[str, Any]:
    folder.mkdir(exist_ok=True)
    path = measure_eye_rays(crew, tracers, scene, folder)
    assert path is not None
    return json.loads(path.read_text())


def test_the_count_of_a_ball_is_that_of_its_outline(crew: Crew, ball: Path, tmp_path: Path):
    record = measured(crew, ball, tmp_path / "out", "haste-cpu", "embree")
    assert (record["rays"], record["film"], record["published"]) == (RAYS, [32, 24], INSIDE)
    assert 200 < INSIDE < 400 and record["reference"]["hits"] == INSIDE, record
    for tracer, other in (("haste-cpu", "embree"), ("embree", "haste-cpu")):
        row = record["tracers"][tracer]
        assert row["hits"] == INSIDE and row["disagreeing"] == 0, row
        assert row["differing"] == {other: 0}, row
        assert row["seconds"] > 0.0, row
    verdicts = judge_eye_rays("ball", record)
    assert [row.tracer for row in verdicts] == ["haste-cpu", "embree"]
    assert all(row.passed for row in verdicts), verdicts


def test_a_count_that_was_not_published_fails(crew: Crew, ball: Path, tmp_path: Path):
    """Negative control: 2 % more rays than the outline holds, where 1 % is allowed."""
    publish(ball, round(1.02 * INSIDE))
    (verdict,) = judge_eye_rays("ball", measured(crew, ball, tmp_path / "out", "haste-cpu"))
    assert isinstance(verdict, EyeRayVerdict)
    assert verdict.agrees and not verdict.counted and not verdict.passed, verdict


def test_a_second_measurement_keeps_the_record_and_another_count_does_not(
    crew: Crew, ball: Path, tmp_path: Path
):
    folder = tmp_path / "out"
    first = measured(crew, ball, folder, "haste-cpu")
    changed = (folder / "eye_rays.json").stat().st_mtime_ns
    assert measured(crew, ball, folder, "haste-cpu") == first
    assert (folder / "eye_rays.json").stat().st_mtime_ns == changed
    publish(ball, INSIDE + 1)
    assert measured(crew, ball, folder, "haste-cpu")["published"] == INSIDE + 1


def test_who_cannot_is_named_with_the_reason_and_keeps_its_images(
    fake: Any, crew: Crew, ball: Path, tmp_path: Path
):
    fake(haste_cuda="Missing", embree="SteadyA", mitsuba_llvm="Picky")
    tracers = ("haste-cuda", "haste-cpu", "embree", "mitsuba-llvm")
    record = measured(crew, ball, tmp_path / "out", *tracers)
    rows = {row.tracer: row for row in judge_eye_rays("ball", record)}
    assert list(rows) == list(tracers)
    reasons = {name: row.reason for name, row in rows.items() if isinstance(row, NoEyeRays)}
    assert reasons == {
        "haste-cuda": "no such machine: apt-get install one",
        "embree": "A traces no rays but those of its own images",
        "mitsuba-llvm": "the scene has a sphere",
    }
    assert all(row.passed for row in rows.values()), rows
    assert crew.rows == [] and crew.takes_part("embree", "path")


def test_a_tracer_that_dies_fails_alone(fake: Any, crew: Crew, ball: Path, tmp_path: Path):
    fake(embree="DyingOfRays")
    record = measured(crew, ball, tmp_path / "out", "haste-cpu", "embree")
    rows = {row.tracer: row for row in judge_eye_rays("ball", record)}
    assert rows["haste-cpu"].passed and not rows["embree"].passed, rows
    assert "SIGABRT" in record["tracers"]["embree"]["reason"], record
    assert record["tracers"]["haste-cpu"]["differing"] == {}, record


def test_a_scene_without_a_published_count_has_no_record(crew: Crew, ball: Path, tmp_path: Path):
    folder = tmp_path / "out"
    measured(crew, ball, folder, "haste-cpu")
    (ball.parent / "settings.yaml").write_text("models: [path]\n")
    assert measure_eye_rays(crew, ["haste-cpu"], ball, folder) is None
    assert not (folder / "eye_rays.json").exists()
