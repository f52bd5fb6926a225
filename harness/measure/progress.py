"""One line at a time on stderr: what is being done, how far it is, how long it has taken."""

import sys
import time
from typing import TextIO

INTERVAL_SECONDS = 2.0


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
