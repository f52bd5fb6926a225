"""The worker processes of one scene's job: started together, replaced when they die."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from harness.measure.config import Config
from harness.measure.messages import Loaded, Ready, Render, Replay, Replayed, Take, Trace
from harness.measure.worker import TracerFailedError, TracerRefusedError, Worker
from harness.scene import RenderSettings
from harness.tracers.base import RenderResult
from harness.tracers.rays import RayHits
from harness.tracers.registry import TRACERS


@dataclass(frozen=True, slots=True)
class NoHits:
    """A tracer that has traced no rays, and why."""

    status: str
    """skipped or failed"""
    reason: str


class Crew:
    """One worker process a tracer, and what became of those that cannot go on.

    Parameters
    ----------
    tracers
        Names of those that will be asked to render.
    threads
        Processor threads of every tracer. Only one renders at a time.
    timeout
        Seconds that one request may take.
    """

    def __init__(self, tracers: Iterable[str], threads: int, timeout: float) -> None:
        self.threads = threads
        self.timeout = timeout
        self.rows: list[dict[str, str]] = []
        self._workers: dict[str, Worker] = {}
        self._ready: dict[str, Ready] = {}
        self._refused: dict[str, str] = {}
        self._out: set[tuple[str, str]] = set()
        # All at once: a process spends its first second or two importing libraries.
        for tracer in tracers:
            self._worker(tracer)

    @classmethod
    def of(cls, config: Config, tracers: Iterable[str], threads: int) -> Self:
        """A crew that may take as long as the settings of the run allow."""
        return cls(tracers, threads, config["timeout_seconds"])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # They leave side by side too.
        for worker in self._workers.values():
            worker.hang_up()
        for worker in self._workers.values():
            worker.close()

    def drop(self, tracer: str, model: str, status: str, reason: str) -> None:
        """Note that a tracer takes no further part in a model, and why."""
        self._out.add((tracer, model))
        self.rows.append({"tracer": tracer, "model": model, "status": status, "reason": reason})

    def _end(self, tracer: str) -> None:
        worker = self._workers.pop(tracer, None)
        if worker is not None:
            worker.close()

    def _fail(self, tracer: str, model: str, error: TracerFailedError) -> None:
        # Whatever state the process is in, nothing more is asked of it.
        self._end(tracer)
        self.drop(tracer, model, "failed", str(error))

    @property
    def failed(self) -> list[dict[str, str]]:
        """The rows of those that did not go on for what is nobody's wish."""
        return [row for row in self.rows if row["status"] == "failed"]

    def absence(self, tracer: str) -> NoHits:
        """Why a tracer that was dropped takes no part, or no further part."""
        row = next(row for row in reversed(self.rows) if row["tracer"] == tracer)
        return NoHits(row["status"], row["reason"])

    def takes_part(self, tracer: str, model: str) -> bool:
        """Whether a tracer has neither been refused nor failed in a model."""
        return (tracer, model) not in self._out

    def _worker(self, tracer: str) -> Worker:
        worker = self._workers.get(tracer)
        if worker is None:
            worker = Worker(tracer, TRACERS[tracer], self.threads, self.timeout)
            self._workers[tracer] = worker
        return worker

    def _probe(self, tracer: str) -> Ready:
        """Ask once whether a tracer can run on this machine."""
        if tracer in self._refused:
            raise TracerRefusedError(self._refused[tracer])
        if tracer not in self._ready:
            try:
                self._ready[tracer] = self._worker(tracer).probe()
            except TracerRefusedError as refusal:
                self._refused[tracer] = str(refusal)
                self._end(tracer)
                raise
        return self._ready[tracer]

    def probe(self, tracers: Iterable[str], model: str) -> dict[str, Ready]:
        """Find which tracers can run on this machine in a model; drop the others."""
        able = {}
        for tracer in tracers:
            try:
                ready = self._probe(tracer)
            except TracerRefusedError as refusal:
                self.drop(tracer, model, "skipped", str(refusal))
            except TracerFailedError as error:
                self._fail(tracer, model, error)
            else:
                if model in ready.models:
                    able[tracer] = ready
                else:
                    names = ", ".join(sorted(ready.models))
                    self.drop(tracer, model, "skipped", f"compared in the model {names} only")
        return able

    def load(self, tracer: str, scene_path: Path, settings: RenderSettings) -> Loaded | None:
        """Make a scene ready; None, and the tracer dropped, where that is not possible."""
        try:
            return self._worker(tracer).load(scene_path, settings)
        except TracerRefusedError as refusal:
            self.drop(tracer, settings.model, "skipped", str(refusal))
        except TracerFailedError as error:
            self._fail(tracer, settings.model, error)
        return None

    def ready(
        self, tracers: Iterable[str], scene_path: Path, settings: RenderSettings
    ) -> dict[str, Ready]:
        """Find which tracers can run on this machine and load a scene; drop the others."""
        return {
            tracer: ready
            for tracer, ready in self.probe(tracers, settings.model).items()
            if self.load(tracer, scene_path, settings) is not None
        }

    def render(self, tracer: str, model: str, request: Render) -> RenderResult | None:
        """Render once; None, and the tracer dropped, where that fails."""
        try:
            return self._workers[tracer].render(request)
        except TracerFailedError as error:
            self._fail(tracer, model, error)
        return None

    def trace(
        self, tracer: str, scene_path: Path, settings: RenderSettings, request: Trace
    ) -> RayHits | NoHits:
        """Load a scene and trace rays through it.

        A tracer that cannot says why, and may still take part in the scene's images.
        """
        try:
            self._probe(tracer)
            self._worker(tracer).load(scene_path, settings)
        except TracerRefusedError as refusal:
            return NoHits("skipped", str(refusal))
        except TracerFailedError as error:
            self._end(tracer)
            return NoHits("failed", str(error))
        return self.trace_loaded(tracer, request)

    def trace_loaded(self, tracer: str, request: Trace) -> RayHits | NoHits:
        """Trace rays through the scene that a tracer has loaded."""
        try:
            return self._workers[tracer].trace(request)
        except TracerRefusedError as refusal:
            return NoHits("skipped", str(refusal))
        except TracerFailedError as error:
            self._end(tracer)
            return NoHits("failed", str(error))

    def take(self, tracer: str, model: str, request: Take) -> None:
        """Have a tracer read rays of a file; it is dropped where that fails.

        Several tracers may be asked by threads of their own: each is another process.
        """
        try:
            self._workers[tracer].take(request)
        except TracerFailedError as error:
            self._fail(tracer, model, error)

    def replay(self, tracer: str, model: str, request: Replay) -> Replayed | NoHits:
        """Trace rays of a file through the scene that a tracer has loaded.

        A tracer that refuses may be asked for other rays, or to trace them in another way; one that
        fails is dropped.
        """
        try:
            return self._workers[tracer].replay(request)
        except TracerRefusedError as refusal:
            return NoHits("skipped", str(refusal))
        except TracerFailedError as error:
            self._fail(tracer, model, error)
            return NoHits("failed", str(error))
