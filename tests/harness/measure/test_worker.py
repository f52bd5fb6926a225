"""One tracer's process, and what becomes of it."""

from pathlib import Path
from typing import Any

import pytest

from harness.measure.messages import Render
from harness.measure.worker import TracerFailedError, TracerRefusedError, Worker
from harness.scene import load_settings

SETTINGS = load_settings({}).render("path", width=8, height=8)


@pytest.fixture
def start(fake: Any, scene_path: Path):
    assert fake.calls() == []
    workers = []

    def begin(kind: str, timeout: float = 60.0) -> Worker:
        worker = Worker(kind.lower(), f"fake_tracers:{kind}", 1, timeout)
        workers.append(worker)
        worker.load(scene_path, SETTINGS)
        return worker

    yield begin
    for worker in workers:
        worker.close()


def test_a_worker_answers_with_the_image_of_its_tracer(start: Any):
    worker = start("SteadyA")
    result = worker.render(Render(seed=7, spp=2))
    assert result.image.shape == (8, 8, 3) and float(result.image.mean()) == 7.0
    assert worker.probe().precision == "watertight"
    worker.close()
    assert not worker.alive


def test_an_exception_in_a_tracer_is_a_failure_with_its_message(start: Any):
    worker = start("Raising")
    with pytest.raises(TracerFailedError, match=r"ValueError: film overflow at pixel \(5, 6\)"):
        worker.render(Render(seed=0, spp=1))


def test_a_crash_is_a_failure_that_names_the_signal_and_the_last_words(start: Any):
    worker = start("Aborting")
    assert worker.render(Render(seed=1, spp=1)).image.max() == 1.0
    with pytest.raises(TracerFailedError, match=r"(?s)killed by SIGABRT.*pixel \(3, 4\)"):
        worker.render(Render(seed=2, spp=1))
    assert not worker.alive


def test_a_tracer_without_an_answer_is_ended(start: Any):
    worker = start("Sleeping", timeout=10.0)
    worker.timeout = 0.5
    with pytest.raises(TracerFailedError, match=r"no answer within 0.5 s"):
        worker.render(Render(seed=0, spp=1))
    worker.close()
    assert not worker.alive


def test_a_missing_library_is_a_refusal_not_a_failure(fake: Any):
    assert fake.calls() == []
    with (
        Worker("missing", "fake_tracers:Missing", 1, 60.0) as worker,
        pytest.raises(TracerRefusedError, match="apt-get install one"),
    ):
        worker.probe()
