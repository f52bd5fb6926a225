"""One line at a time on stderr: what is being done, how far it is, how long it has taken."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

INTERVAL_SECONDS = 2.0


class Stages:
    """What the time of a piece of work goes into."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Count the time of a block; blocks of one name add up."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def __str__(self) -> str:
        parts = ", ".join(f"{name} {seconds:.1f}" for name, seconds in self.seconds.items())
        return f"{sum(self.seconds.values()):.1f} s ({parts})"


class Progress:
    """Reports a scene's renders as they are done.

    Parameters
    ----------
    scene
        Its name, which opens every line.
    stream
        Where the lines go.
    """

    def __init__(self, scene: str, stream: TextIO | None = None) -> None:
        self.scene = scene
        self.done = 0
        self.total = 0
        self._stream = stream or sys.stderr
        self._start = time.perf_counter()
        self._last = 0.0

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self._start

    def say(self, text: str) -> None:
        """Write a line now."""
        print(f"{self.scene}: {text}", file=self._stream, flush=True)

    def hint(self, text: str) -> None:
        """Write a line if the last one is two seconds old."""
        now = time.perf_counter()
        if now - self._last >= INTERVAL_SECONDS:
            self._last = now
            self.say(text)

    def step(self, model: str, tracer: str, what: str) -> None:
        """Count one render, and say so now and then."""
        self.done += 1
        self.hint(
            f"{model} {tracer} {what}  [{self.done}/{self.total} renders]  {self.elapsed:.0f} s"
        )
