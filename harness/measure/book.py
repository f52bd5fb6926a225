"""The times, ray counts and hashes of one scene's job, kept in three JSON files."""

from collections import defaultdict
from dataclasses import asdict
from pathlib import Path
from typing import Any

from harness.measure.files import key_of, read_json, write_json
from harness.measure.messages import Loaded, Render
from harness.measure.plan import Subject
from harness.tracers.base import RenderResult

Row = dict[str, Any]


def _count_key(subject: Subject, request: Render) -> str:
    """Hash what a ray count depends on: not the size or order of packets."""
    parts = {"engine": request.engine, "seed": request.seed, "spp": request.spp}
    return key_of({"subject": subject.key, **parts})


class TimeBook:
    """Timed and counted renders, and what was loaded for them.

    timing.json, rays.json and hashes.json are written whole whenever something is added, so that a
    job that is killed forgets nothing.

    Parameters
    ----------
    folder
        The scene's folder of results.
    """

    def __init__(self, folder: Path) -> None:
        self._times = folder / "timing.json"
        self._counts = folder / "rays.json"
        self._hashes = folder / "hashes.json"
        self.rows: list[Row] = read_json(self._times) or []
        self.counts: list[Row] = read_json(self._counts) or []
        self.hashes: dict[str, str] = read_json(self._hashes) or {}

    def keep_only(self, keys: set[str], subjects: set[str]) -> None:
        """Forget rows of other settings, other code or another state of the scene."""
        self.rows = [row for row in self.rows if row["key"] in keys]
        self.counts = [row for row in self.counts if row["subject"] in subjects]
        self.save()

    def add(self, row: Row) -> None:
        """Add a timed render."""
        self.rows.append(row)
        write_json(self._times, self.rows)

    def add_hashes(self, loaded: Loaded) -> None:
        """Keep the hashes of what a tracer has loaded: not every resumed job loads it again."""
        self.hashes |= loaded.hashes
        write_json(self._hashes, self.hashes)

    def counted(self, subject: Subject, request: Render) -> Row | None:
        """Find the counted render of the same engine, seed and samples."""
        key = _count_key(subject, request)
        return next((row for row in self.counts if row["key"] == key), None)

    def add_count(self, subject: Subject, request: Render, result: RenderResult) -> None:
        """Add a counted render."""
        self.counts.append(
            {
                "key": _count_key(subject, request),
                "subject": subject.key,
                "tracer": subject.tracer,
                "model": subject.model,
                "engine": request.engine,
                "seed": request.seed,
                "spp": request.spp,
                "rays": asdict(result.rays) if result.rays is not None else None,
                "film_sha256": result.film_sha256,
            }
        )
        write_json(self._counts, self.counts)

    def save(self) -> None:
        """Write both files, also where there is nothing in them."""
        write_json(self._times, self.rows)
        write_json(self._counts, self.counts)

    def films(self) -> list[Row]:
        """Compare the films of all renders of one seed and sample count, over engines and packets.

        Returns
        -------
        list
            A row for each tracer, model, seed and spp: number of renders, of different films, and
            the engines compared. A tracer that promises equal films shows one film.
        """
        groups: dict[tuple[str, str, int, int], list[Row]] = defaultdict(list)
        for row in (*self.counts, *self.rows):
            if row["film_sha256"] is not None:
                group = (row["tracer"], row["model"], row["seed"], row["spp"])
                groups[group].append(row)
        return [
            {
                "tracer": tracer,
                "model": model,
                "seed": seed,
                "spp": spp,
                "renders": len(rows),
                "different_films": len({row["film_sha256"] for row in rows}),
                "engines": sorted({row["engine"] for row in rows}),
            }
            for (tracer, model, seed, spp), rows in groups.items()
        ]
