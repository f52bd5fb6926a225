"""A folder of results that is one process's alone, as long as that works in it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from harness.locks import alone
from harness.measure.files import remove_partial
from harness.measure.progress import Progress


@contextmanager
def own_folder(
    folder: Path, work: str, title: str, *, of_truth: bool = False, shared: bool = False
) -> Iterator[Progress]:
    """Have a folder to oneself, cleared of what a killed process left half written.

    One process at a time does the same work in it; another one waits, and finds what the first has
    completed.

    Parameters
    ----------
    folder
        The folder, made if it is not there.
    work
        What is done, which the lock's file is named after: ``rays``.
    title
        Opens every line of the progress.
    of_truth
        Whether the truth of a scene is clear of partial files thereafter, or all but the truth.
    shared
        Whether others write to the folder meanwhile: what is half written may be theirs, and stays.
    """
    progress = Progress(title)
    with alone(folder / f".{work}.lock", progress.say):
        if not shared:
            remove_partial(folder, of_truth=of_truth)
        yield progress
