"""The one exception that scene import raises."""

from collections.abc import Iterable


class SceneError(ValueError):
    """A scene or its settings cannot be used.

    `source` names the scene or file, `problems` holds one line for each thing that is wrong with
    it, each naming the thing and its place.
    """

    def __init__(self, source: str, problems: Iterable[str]) -> None:
        self.source = source
        self.problems = tuple(problems)
        if len(self.problems) == 1:
            message = f"{source}: {self.problems[0]}"
        else:
            lines = "".join(f"\n  - {problem}" for problem in self.problems)
            message = f"{source}: {len(self.problems)} problems{lines}"
        super().__init__(message)
