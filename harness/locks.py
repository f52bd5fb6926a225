"""Locks that the kernel lets go of when their process ends, however it ends."""

from __future__ import annotations

import errno
import fcntl
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

WITHOUT_LOCKS = frozenset({errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP})
"""What file systems answer that have no locks."""


@contextmanager
def alone(path: Path, say: Callable[[str], object]) -> Iterator[None]:
    """Wait until no other process is in a block with the same file, then run this one.

    The file stays, empty. Where the file system has no locks, nobody waits.

    Parameters
    ----------
    path
        The file, made with its folder if it is not there.
    say
        Called with a line of text before waiting.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say(f"another process is at it ({path}); waiting until it has ended")
            fcntl.flock(file, fcntl.LOCK_EX)
        except OSError as error:
            if error.errno not in WITHOUT_LOCKS:
                raise
        yield


def join_runs(folder: Path) -> TextIO:
    """Take part in the runs of a working directory, and clear away the lock of one that was killed.

    Snakemake's lock is a list of files, which stays when its process is killed, and the next run is
    refused. Every run shares a lock of the kernel's on another file from before it takes
    Snakemake's until it ends; whoever can have that alone is the only one, so that a list which is
    there belongs to nobody.

    Parameters
    ----------
    folder
        Snakemake's own, `.snakemake` in the working directory.

    Returns
    -------
    TextIO
        The shared lock, as long as the file is open. Processes that are started do not inherit it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file = (folder / "runs.lock").open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for name in (folder / "locks").glob("*.lock"):
            name.unlink(missing_ok=True)
        fcntl.flock(file, fcntl.LOCK_SH)
    except BlockingIOError:
        fcntl.flock(file, fcntl.LOCK_SH)
    except OSError as error:
        if error.errno not in WITHOUT_LOCKS:
            raise
    return file
