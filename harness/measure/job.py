"""One scene's job: every tracer in every model, in turn, while nothing else runs.

Each image is a file that is complete or not there, and so is each table of times. A job that was
interrupted goes on from those whose key says that they are still what is wanted.
"""

import platform
import resource
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from harness.measure.answers import expected_answers
from harness.measure.book import TimeBook
from harness.measure.config import Config
from harness.measure.crew import Crew
from harness.measure.eye_rays import measure_eye_rays
from harness.measure.files import keep_only, write_json
from harness.measure.model_job import ModelJob, Share
from harness.measure.plan import (
    plan_convergence,
    plan_engines,
    plan_knobs,
    plan_packets,
    plan_seeds,
    plan_timing,
)
from harness.measure.progress import Progress
from harness.measure.scene_job import SceneJob, scene_job
from harness.scene import RenderSettings

SUMMARY = "measured.json"
"""Written last: that it is there says that the job is complete."""
UNTAKEN = "untaken.json"
"""Turns of knobs that a tracer has not, and why."""


def _shares(job: SceneJob, crew: Crew, render: RenderSettings) -> list[Share]:
    """Plan the whole work of every tracer that this machine can run in a model.

    A scene with a known answer is judged and not timed: rays a second over a patch of wall, seen
    through a keyhole, are those of no scene that anybody renders.
    """
    config, timed = job.config, not job.settings.answer
    shares = []
    for tracer, ready in crew.probe(config["tracers"], render.model).items():
        subject = job.subject(tracer, render)
        knobs, untaken = plan_knobs(config, subject, render, ready.knobs) if timed else ([], [])
        shares.append(
            Share(
                subject=subject,
                ready=ready,
                timing=plan_timing(config, subject) if timed else [],
                seeds=plan_seeds(config, subject),
                convergence=plan_convergence(config, subject) if timed else [],
                packets=plan_packets(config, subject, ready.engines) if timed else [],
                engines=plan_engines(config, subject, ready.engines) if timed else [],
                knobs=knobs,
                untaken=untaken,
            )
        )
    return shares


def _description(job: SceneJob, size: tuple[int, int]) -> dict[str, Any]:
    scene, settings = job.scene, job.settings
    return {
        "features": list(scene.features.names()),
        "settings": asdict(settings),
        "caustic": settings.caustic,
        "resolution": list(size),
        "triangles": len(scene.triangles),
        "spheres": len(scene.spheres),
        "shapes": len(scene.shapes),
        "lights": len(scene.lights),
        "dropped": [str(lost) for lost in scene.dropped],
    }


def measure_scene(config: Config, name: str, threads: int) -> Path:
    """Render and time everything that the settings ask for in one scene.

    One process at a time does that; another one waits, and finds what the first has completed.

    Parameters
    ----------
    config
        The run's settings.
    name
        One of its scenes.
    threads
        Processor threads of every tracer; one tracer renders at a time.

    Returns
    -------
    Path
        The summary, written last.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    reference.analytic.AnswerError
        The scene has no such known answer.
    """
    path, folder, size = config.scenes[name], config.scene_dir(name), config.resolution(name)
    with scene_job(config, path, folder, "measure", threads, size=size) as job:
        return _measure(job, name, size)


def _measure(job: SceneJob, name: str, wanted: tuple[int | None, int | None]) -> Path:
    started = time.time()
    config, folder, settings, progress = job.config, job.folder, job.settings, job.progress
    width, height = wanted
    models = [model for model in config["models"] if model in settings.models]
    renders = {model: settings.render(model, width=width, height=height) for model in models}
    answers = expected_answers(settings.answer, job.scene, renders)
    job.note_provenance()

    seconds: dict[str, float] = {}
    with job.crew(config["tracers"]) as crew:
        for model in config["models"]:
            if model not in models:
                for tracer in config["tracers"]:
                    crew.drop(tracer, model, "skipped", "not among the models of the scene")
        plans = {model: _shares(job, crew, renders[model]) for model in models}
        shares = [share for plan in plans.values() for share in plan]
        book = TimeBook(folder)
        book.keep_only(
            {time.key for share in shares for time in share.times},
            {share.subject.key for share in shares},
        )
        for kind in ("seeds", "convergence", "knobs"):
            keep_only(
                folder / kind,
                {folder / image.stem for share in shares for image in share.images},
            )
        todo = {model: [share.left(folder, book) for share in plans[model]] for model in models}
        planned = sum(len(share) for share in shares)
        progress.total = sum(len(share) for plan in todo.values() for share in plan)
        progress.say(
            f"{planned} renders planned, {planned - progress.total} there already, "
            f"{len(models)} models, {len({share.subject.tracer for share in shares})} tracers, "
            f"{job.threads} threads"
        )
        for model in models:
            start = progress.elapsed
            ModelJob(crew, progress, book, folder, job.path, renders[model]).run(todo[model])
            seconds[model] = progress.elapsed - start
        measure_eye_rays(crew, config["tracers"], job.path, folder)
        rows = crew.rows
    for row in rows:
        progress.say(f"{row['model']} {row['tracer']} {row['status']}: {row['reason']}")
    size = next(((one.width, one.height) for one in renders.values()), (0, 0))
    description = {**_description(job, size), **book.hashes}
    job.describe(**description, answers=answers, hashes=book.hashes, films=book.films())
    write_json(folder / "skipped.json", rows)
    untaken = [one for share in shares for one in share.untaken]
    write_json(
        folder / UNTAKEN,
        [
            {
                "tracer": one.subject.tracer,
                "model": one.subject.model,
                "case": one.case,
                "reason": one.reason,
            }
            for one in untaken
        ],
    )
    book.save()
    _say_budget(config, progress)
    return job.finish(
        SUMMARY,
        scene=name,
        threads=job.threads,
        host=platform.node(),
        started=started,
        ended=time.time(),
        seconds=seconds,
        processor_seconds=_processor_seconds(),
        renders=progress.done,
        planned=planned,
        failed=crew.failed,
    )


def _processor_seconds() -> float:
    """Processor time of this process and of its workers, which have ended by now."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def _say_budget(config: Config, progress: Progress) -> None:
    text = f"{progress.done} renders in {progress.elapsed:.0f} s"
    budget = config.values.get("budget_seconds")
    if budget:
        text += f"; {budget / len(config.scenes):.0f} s are planned for a scene, its truth included"
    # Much less processor time than threads times seconds: somebody else was at work.
    progress.say(f"{text}; {_processor_seconds():.0f} s of processor time")
