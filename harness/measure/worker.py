"""One process a tracer: a crash or a kernel fault ends that process and nothing else."""

import multiprocessing
import os
import signal
import sys
import tempfile
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Self

from harness.measure.messages import (
    Answer,
    Failed,
    Load,
    Loaded,
    Probe,
    Ready,
    Refused,
    Render,
    Replay,
    Replayed,
    Request,
    Take,
    Taken,
    Trace,
)
from harness.measure.wire import receive, send
from harness.scene import RenderSettings
from harness.tracers.base import RenderResult, Tracer, UnsupportedError
from harness.tracers.rays import RayHits
from harness.tracers.registry import load_tracer

STDERR_LINES = 12
"""Lines of a dead worker's last words that its error repeats."""


class TracerFailedError(Exception):
    """A tracer raised, crashed or did not answer in time; the message says which, and why."""


class TracerRefusedError(Exception):
    """A tracer cannot run here or on this scene; the message is the reason of a skipped row."""


def _answer(tracer: Tracer, request: Request) -> Answer:
    match request:
        case Probe():
            reason = tracer.unavailable()
            if reason is not None:
                return Refused(reason)
            return Ready(
                models=tracer.models,
                engines=tracer.engines,
                precision=tracer.precision,
                warm_ups=tracer.warm_ups,
                ways=tracer.ways(),
                on_gpu=tracer.on_gpu,
                knobs=tracer.knobs,
            )
        case Load(scene_path, settings):
            try:
                times = tracer.load(scene_path, settings)
                return Loaded(times, tracer.hashes)
            except UnsupportedError as refusal:
                return Refused(str(refusal))
        case Render(seed, spp, engine, options, count_rays):
            return tracer.render(seed, spp, engine=engine, options=options, count_rays=count_rays)
        case Trace(origins, directions, t_min, t_max, any_hit):
            try:
                return tracer.trace(origins, directions, t_min, t_max, any_hit=any_hit)
            except UnsupportedError as refusal:
                return Refused(str(refusal))
        case Take():
            from harness.measure.replay import take

            take(tracer, request)
            return Taken()
        case Replay():
            from harness.measure.replay import replay

            try:
                return replay(tracer, request)
            except UnsupportedError as refusal:
                return Refused(str(refusal))


def _serve(connection: Connection, target: str, threads: int, log: str) -> None:
    """Run the child: answer requests until the parent closes the pipe, or something raises."""
    # The parent decides what an interrupt from the terminal means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Libraries write to the descriptors, not to sys.stderr, and keep doing so while they abort.
    with Path(log).open("ab", buffering=0) as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    try:
        tracer = load_tracer(target)(threads)
        while True:
            try:
                request = receive(connection)
            except EOFError:
                return
            send(connection, _answer(tracer, request))
    except BrokenPipeError:
        return
    except BaseException as error:  # noqa: BLE001 - the parent must hear of everything
        traceback.print_exc()
        send(connection, Failed(f"{type(error).__name__}: {error}"))
        sys.exit(1)


def _exit_description(code: int | None) -> str:
    if code is None:
        return "it is still running"
    if code < 0:
        try:
            return f"killed by {signal.Signals(-code).name}"
        except ValueError:
            return f"killed by signal {-code}"
    return f"exit code {code}"


class Worker:
    """A tracer in a process of its own. Use as a context manager.

    Parameters
    ----------
    name
        The tracer's name, for messages.
    target
        Its class, ``module:class``.
    threads
        Processor threads it may use.
    timeout
        Seconds after which a request without an answer counts as a failure.
    """

    def __init__(self, name: str, target: str, threads: int, timeout: float) -> None:
        self.name = name
        self.timeout = timeout
        descriptor, log = tempfile.mkstemp(prefix=f"{name}-", suffix=".log")
        os.close(descriptor)
        self._log = Path(log)
        context = multiprocessing.get_context("spawn")
        self._connection, child = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(child, target, threads, log), name=name, daemon=True
        )
        self._process.start()
        # Ours alone, so that the child sees the end of the pipe when this process goes.
        child.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def alive(self) -> bool:
        """Whether the process still runs."""
        return self._process.is_alive()

    def hang_up(self) -> None:
        """Ask for nothing more: a process that is idle ends itself."""
        self._connection.close()

    def close(self) -> None:
        """End the process, kindly if it is idle, and forget its log."""
        self.hang_up()
        self._process.join(timeout=0.5)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join(timeout=5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._log.unlink(missing_ok=True)

    def _last_words(self) -> str:
        text = self._log.read_text(errors="replace").strip() if self._log.exists() else ""
        return "\n".join(text.splitlines()[-STDERR_LINES:])

    def _ask(self, request: Request) -> Answer:
        """Send a request and wait for the answer.

        Raises
        ------
        TracerRefusedError
            The tracer cannot do it, and says why.
        TracerFailedError
            It raised, its process died, or it took longer than the timeout.
        """
        try:
            send(self._connection, request)
            if not self._connection.poll(self.timeout):
                self._process.kill()
                raise TracerFailedError(
                    f"{self.name}: no answer within {self.timeout:g} s; its process was ended"
                )
            answer: Answer = receive(self._connection)
        except (EOFError, ConnectionError) as broken:
            self._process.join(timeout=5.0)
            words = self._last_words()
            raise TracerFailedError(
                f"{self.name}: its process died ({_exit_description(self._process.exitcode)})"
                + (f"; its last words:\n{words}" if words else ", without a word")
            ) from broken
        match answer:
            case Refused(reason):
                raise TracerRefusedError(reason)
            case Failed(message):
                raise TracerFailedError(f"{self.name}: {message}")
        return answer

    def probe(self) -> Ready:
        """Ask whether the tracer can run on this machine."""
        answer = self._ask(Probe())
        assert isinstance(answer, Ready)
        return answer

    def load(self, scene_path: Path, settings: RenderSettings) -> Loaded:
        """Make a scene ready; split times and sizes, named with their units, and hashes."""
        answer = self._ask(Load(scene_path, settings))
        assert isinstance(answer, Loaded)
        return answer

    def render(self, request: Render) -> RenderResult:
        """Render the loaded scene once."""
        answer = self._ask(request)
        assert isinstance(answer, RenderResult)
        return answer

    def trace(self, request: Trace) -> RayHits:
        """Trace rays through the loaded scene."""
        answer = self._ask(request)
        assert isinstance(answer, RayHits)
        return answer

    def take(self, request: Take) -> None:
        """Have the tracer read a class of rays of a file."""
        answer = self._ask(request)
        assert isinstance(answer, Taken)

    def replay(self, request: Replay) -> Replayed:
        """Trace a class of rays of a file through the loaded scene."""
        answer = self._ask(request)
        assert isinstance(answer, Replayed)
        return answer
