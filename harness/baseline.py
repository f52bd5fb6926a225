"""The baseline: a run's snapshots under version control, which later runs must not fall behind."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from harness.bounds import GateSettings
from harness.regression import Regression, describe_change, judge_changes
from harness.snapshot import Snapshot, from_record, snapshots_of, to_record
from harness.statistics.bias import Verdict
from harness.statistics.change import Speed
from harness.tables.provenance import merge_provenance
from harness.tables.read import ResultsError, read_jobs, read_json
from harness.whole_files import write_whole

PROVENANCE = "provenance.json"
MOST_BYTES = 300_000
"""A baseline is committed; it must stay small."""


def read_baseline(folder: Path) -> list[Snapshot]:
    """Read every snapshot of a baseline; empty where there is none. Raises ResultsError."""
    found = []
    for path in sorted(folder.glob("*.json")):
        if path.name == PROVENANCE:
            continue
        record = read_json(path)
        try:
            found += [from_record(record["scene"], row) for row in record["snapshots"]]
        except (KeyError, TypeError, ValueError) as error:
            raise ResultsError(f"{path}: not a scene of a baseline ({error!r})") from error
    return found


def write_baseline(folder: Path, snapshots: list[Snapshot], provenance: dict[str, Any]) -> int:
    """Write a baseline in the place of what was there; returns its size in bytes.

    Scenes that are not among the snapshots are removed. Raises ResultsError, before anything is
    written, where the files would be larger than MOST_BYTES.
    """
    scenes: dict[str, list[Snapshot]] = {}
    for snapshot in snapshots:
        scenes.setdefault(snapshot.scene, []).append(snapshot)
    files = {f"{scene}.json": _scene_text(scene, rows) for scene, rows in scenes.items()}
    files[PROVENANCE] = json.dumps(provenance, indent=1, sort_keys=True) + "\n"
    size = sum(len(text) for text in files.values())
    if size > MOST_BYTES:
        raise ResultsError(
            f"{folder}: a baseline of {size} bytes; at most {MOST_BYTES} may be committed. "
            "Take fewer scenes, or smaller images (config/check.yaml)"
        )
    for name, text in files.items():
        write_whole(folder / name, text)
    for path in folder.glob("*.json"):
        if path.name not in files:
            path.unlink()
    return size


def _scene_text(scene: str, snapshots: list[Snapshot]) -> str:
    """JSON with a line a tracer and model, so that a renewal shows in a diff what it changes."""
    rows = ",\n".join(json.dumps(to_record(snapshot)) for snapshot in snapshots)
    return f'{{"scene": {json.dumps(scene)}, "snapshots": [\n{rows}\n]}}\n'


def shortened(provenance: dict[str, Any]) -> dict[str, Any]:
    """Of a run's provenance what a baseline needs beside its times' machine: which, with what."""
    wanted = ("run", "commit", "dirty", "packages", "python", "threads")
    return {name: provenance[name] for name in wanted if name in provenance}


def renew(
    results_dir: Path,
    folder: Path,
    settings: GateSettings,
    agree: Callable[[], bool],
) -> int:
    """Show what a new baseline would change, and write it if `agree` says so.

    Returns 0 where the baseline is that of the run, 1 where it was not renewed.
    """
    try:
        jobs = read_jobs(results_dir)
        snapshots = [row for job in jobs for row in snapshots_of(job, settings.tile)]
        if not snapshots:
            raise ResultsError(f"{results_dir}: no tracer has images to make a baseline of")  # noqa: TRY301
        before = read_baseline(folder)
        caustic = {job.name for job in jobs if job.caustic}
        for line in describe_renewal(snapshots, before, settings, caustic):
            print(line)
        if not agree():
            print(f"{folder} is as it was")
            return 1
        size = write_baseline(
            folder,
            snapshots,
            shortened(merge_provenance({job.name: job.provenance for job in jobs})),
        )
    except ResultsError as error:
        print(f"baseline: {error}", file=sys.stderr)
        return 1
    print(f"{folder}: {len(snapshots)} snapshots of {len(jobs)} scenes, {size} bytes")
    return 0


def describe_renewal(
    now: list[Snapshot], before: list[Snapshot], settings: GateSettings, caustic: set[str]
) -> list[str]:
    """One line for everything that is new, gone or different, and one for all."""
    changes = judge_changes(now, before, settings, caustic)
    old, new = {row.subject for row in before}, {row.subject for row in now}
    lines = [f"{'new':<18} {' '.join(row.subject)}" for row in now if row.subject not in old]
    lines += [f"{'gone':<18} {' '.join(row.subject)}" for row in before if row.subject not in new]
    differing = [row for row in changes if is_different(row)]
    lines += [describe_change(row) for row in differing]
    lines.append(
        f"{len(new - old)} new, {len(old - new)} gone, {len(differing)} different, "
        f"{len(changes) - len(differing)} as they were"
    )
    return lines


def is_different(change: Regression) -> bool:
    """Whether a comparison with the baseline found anything but equality."""
    other_speed = change.speed in {Speed.FASTER, Speed.SLOWER}
    return change.verdict is not Verdict.PASS or bool(change.note) or change.moved or other_speed
