"""The study of packets: one scene in one model, every engine at every size of a launch, in turn.

A render is one row of a file, which is written whole after each of them. A job that was interrupted
goes on with the rows that are missing.
"""

import math
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from harness.measure.config import Config
from harness.measure.counters import NvmlError, read_clocks, read_energy
from harness.measure.crew import Crew
from harness.measure.files import read_json, write_json
from harness.measure.messages import Render
from harness.measure.plan import in_turn
from harness.measure.scene_job import SceneJob, scene_job
from harness.measure.study_plan import SEED, StudyPlan, StudyRender
from harness.scene import RenderSettings
from harness.statistics.work_spans import summarise_work
from harness.tracers.base import RenderResult

SUMMARY = "studied.json"
"""Written last: that it is there says that the study is complete."""
ROWS, WORK = "rows.json", "work.json"
COUNT_SPP = 4
"""Samples a pixel of the render that counts rays."""
SHOWN_SPANS = 400
"""Spans of a render that are kept for the time line, from its middle on."""
COPY_BYTES = 1 << 28
"""Size of the copies that the bus and the memory are measured with."""

Row = dict[str, Any]


@dataclass(slots=True)
class _Book:
    """The rows of one file; each says by its key what it is the result of."""

    path: Path
    rows: list[Row]

    @classmethod
    def open(cls, path: Path) -> "_Book":
        return cls(path, read_json(path) or [])

    def keep_only(self, keys: set[str]) -> None:
        """Forget failures, and rows of other settings, other code or another state of the scene."""
        self.rows = [row for row in self.rows if row["key"] in keys and row["status"] == "ok"]
        write_json(self.path, self.rows)

    def add(self, row: Row) -> None:
        self.rows.append(row)
        write_json(self.path, self.rows)

    def count(self, key: str) -> int:
        return sum(row["key"] == key for row in self.rows)


def study_scene(config: Config, name: str, model: str, threads: int) -> Path:
    """Render a scene in a model with every engine of every tracer, at every size of a launch.

    Parameters
    ----------
    config
        The run's settings; its section `study` says what is swept.
    name, model
        One of `config.study_panels`.
    threads
        Processor threads of every tracer; one renders at a time.

    Returns
    -------
    Path
        The summary, written last.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    """
    path, folder = config.study_scenes[name], config.study_dir(name, model)
    title = f"{name} {model}"
    with scene_job(config, path, folder, "study", threads, title=title) as job:
        tracers = config["study"]["tracers"]
        with job.crew(tracers) as crew:
            study = _Study(job, crew, name, model)
            # A job that is interrupted has said by then what its rows are of.
            job.note_provenance()
            study.describe()
            study.run(tracers)
        study.describe(crew.rows)
        seconds, renders = job.progress.elapsed, job.progress.done
        job.progress.say(f"study complete: {renders} renders in {seconds:.0f} s")
        return job.finish(SUMMARY, seconds=seconds, renders=renders, absent=crew.rows)


class _Study:
    """The study of one scene in one model."""

    def __init__(self, job: SceneJob, crew: Crew, name: str, model: str) -> None:
        self.job, self.crew, self.progress = job, crew, job.progress
        self.name, self.model = name, model
        self.settings: dict[str, Any] = job.config["study"]
        self.rows, self.work = (_Book.open(job.folder / file) for file in (ROWS, WORK))
        self.energy_reason = ""
        # While the tracers are idle.
        self.copies = _copy_rates()

    def _render_settings(self, width: int) -> RenderSettings:
        return replace(
            self.job.settings.render(self.model, width=width, height=width),
            light_samples=self.settings["light_samples"],
            ambient_samples=self.settings["ambient_samples"],
        )

    def describe(self, absent: Sequence[Row] = ()) -> None:
        """Write what is studied, and what the machine's copies reach."""
        self.job.describe(
            model=self.model,
            settings=asdict(self._render_settings(self.settings["width"])),
            triangles=len(self.job.scene.triangles),
            spheres=len(self.job.scene.spheres),
            clocks=read_clocks(),
            energy=self.energy_reason,
            absent=list(absent),
            copies=self.copies,
            films=self._films(),
        )

    def _films(self) -> list[Row]:
        """Compare the films of all renders of one image, over engines and launches."""
        groups: dict[tuple[str, int, int], list[Row]] = defaultdict(list)
        for row in (*self.rows.rows, *self.work.rows):
            if row.get("film_sha256") is not None:
                groups[row["tracer"], row["width"], row["spp"]].append(row)
        return [
            {
                "tracer": tracer,
                "model": self.model,
                "seed": SEED,
                "width": width,
                "spp": spp,
                "renders": len(rows),
                "different_films": len({row["film_sha256"] for row in rows}),
                "engines": sorted({row["engine"] for row in rows}),
            }
            for (tracer, width, spp), rows in groups.items()
        ]

    def run(self, tracers: Sequence[str]) -> None:
        """Render what an earlier run has not completed, tracer by tracer."""
        plans = {}
        for tracer, ready in self.crew.probe(tracers, self.model).items():
            if len(ready.engines) < 2:
                self.crew.drop(tracer, self.model, "skipped", "it has one engine")
                continue
            counts = self._count(tracer)
            if counts is None:
                continue
            queued = counts["camera"] + counts["bounce"] + counts["ambient"]
            sizes = self.job.config.study_sizes(tracer, self.name, self.model)
            plan = StudyPlan(self.settings, ready.engines, sizes, queued / counts["camera"])
            subject = self.job.subject(tracer, self._render_settings(self.settings["width"]))
            fixed = {
                "tracer": tracer,
                "precision": ready.precision,
                "rays_per_sample": {kind: n / counts["camera"] for kind, n in counts.items()},
            }
            plans[tracer] = (plan, subject.key, fixed)
        renders = {tracer: plan.renders() for tracer, (plan, _, _) in plans.items()}
        keys = {
            render.key(plans[tracer][1]) for tracer, found in renders.items() for render in found
        }
        for book in (self.rows, self.work):
            book.keep_only(keys)
        planned = [render for found in renders.values() for render in found]
        self.progress.total = sum(1 + render.repeats for render in planned)
        there = len(self.rows.rows) + len(self.work.rows)
        self.progress.say(f"{self.progress.total} renders planned, {there} there already")
        self.progress.total -= there
        for tracer, found in renders.items():
            plan, subject_key, fixed = plans[tracer]
            for width in sorted({render.width for render in found}):
                of_width = [render for render in found if render.width == width]
                self._take(tracer, width, of_width, subject_key, fixed, spans=plan.on_device)

    def _count(self, tracer: str) -> dict[str, int] | None:
        """Rays of one render by class."""
        settings = self._render_settings(self.settings["width"])
        if self.crew.load(tracer, self.job.path, settings) is None:
            return None
        request = Render(seed=SEED, spp=COUNT_SPP, count_rays=True)
        result = self.crew.render(tracer, self.model, request)
        return asdict(result.rays) if result is not None and result.rays is not None else None

    def _take(
        self,
        tracer: str,
        width: int,
        renders: Sequence[StudyRender],
        subject: str,
        fixed: Row,
        *,
        spans: bool,
    ) -> None:
        """Look into each render once, and then time them, each once before any of them again."""
        keyed = [(render, render.key(subject)) for render in renders]
        fresh = [(render, key) for render, key in keyed if not self.work.count(key)]
        timed = [[(r, key)] * max(0, r.repeats - self.rows.count(key)) for r, key in keyed]
        if not fresh and not any(timed):
            return
        if self.crew.load(tracer, self.job.path, self._render_settings(width)) is None:
            return
        failed: set[str] = set()

        def render(one: StudyRender, key: str, book: _Book, *, record: bool) -> None:
            if key in failed:
                return
            request = one.request
            if record and spans:
                request = replace(request, options={**request.options, "record_spans": True})
            result = self.crew.render(tracer, self.model, request)
            row: Row = {**fixed, "key": key, "engine": one.engine, "case": one.case}
            row |= {"width": one.width, "spp": one.spp, "samples": one.samples}
            if result is None:
                # Too little memory for one size says nothing of the others.
                failed.add(key)
                book.add({**row, "status": "failed", "note": self.crew.rows.pop()["reason"]})
                self.crew.load(tracer, self.job.path, self._render_settings(width))
                return
            more = self._looked_into(tracer, one, result) if record else {}
            number = book.count(key)
            row |= {"repeat": number, "status": "ok", "note": "", "seconds": result.seconds}
            book.add({**row, "film_sha256": result.film_sha256, **result.extras, **more})
            self.progress.step(self.model, tracer, f"{one.engine} {one.case}")

        for one, key in fresh:
            render(one, key, self.work, record=True)
        for one, key in in_turn(timed):
            render(one, key, self.rows, record=False)

    def _looked_into(self, tracer: str, one: StudyRender, result: RenderResult) -> Row:
        """What the spans of a render say, some of them for the time line, and its energy."""
        found: Row = {}
        if result.spans:
            work = asdict(summarise_work(result.spans))
            found = {name: value for name, value in work.items() if math.isfinite(value)}
            if one.case.get("packet") == self.settings["timeline_packet"]:
                middle = max(0, (len(result.spans) - SHOWN_SPANS) // 2)
                shown = result.spans[middle : middle + SHOWN_SPANS]
                found["spans"] = [asdict(span) for span in shown]
        if one.with_joules and not self.energy_reason:
            try:
                found |= self._joules(tracer, one)
            except NvmlError as error:
                self.energy_reason = str(error)
        return found

    def _joules(self, tracer: str, one: StudyRender) -> Row:
        """Energy of the GPU for one render, from as many as the settings' seconds hold."""
        begin, energy, renders = time.perf_counter(), read_energy(), 0
        while renders == 0 or time.perf_counter() - begin < self.settings["joules_seconds"]:
            if self.crew.render(tracer, self.model, one.request) is None:
                return {}
            renders += 1
        return {"joules": (read_energy() - energy) / renders}


def _copy_rates() -> dict[str, float] | None:
    """Bytes a second of copies, None without a GPU; nothing else may be under way."""
    try:
        import haste_cuda
    except ImportError:
        return None
    if haste_cuda.cuda_unavailable() is not None:
        return None
    return dict(haste_cuda.copy_rates(COPY_BYTES))
