"""One scene in one model: what is left to render, and the rendering of it, the tracers in turn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from harness.measure.book import TimeBook
from harness.measure.crew import Crew
from harness.measure.files import read_json, write_image, write_json
from harness.measure.messages import Loaded, Ready, Render
from harness.measure.plan import PlannedImage, PlannedTime, Subject, Untaken, in_turn
from harness.measure.progress import Progress
from harness.scene import RenderSettings
from harness.tracers.base import RenderResult


def image_is_finished(folder: Path, image: PlannedImage) -> bool:
    """Whether an earlier run completed an image, from the same scene, settings and code."""
    stem = folder / image.stem
    record = read_json(stem.with_suffix(".json"))
    return (
        isinstance(record, dict)
        and record.get("key") == image.key
        and stem.with_suffix(".npy").is_file()
    )


@dataclass(frozen=True, slots=True)
class Share:
    """One tracer's part of the work."""

    subject: Subject
    ready: Ready
    timing: Sequence[PlannedTime]
    seeds: Sequence[PlannedImage]
    convergence: Sequence[PlannedImage]
    packets: Sequence[PlannedTime]
    engines: Sequence[PlannedTime]
    knobs: Sequence[PlannedImage]
    untaken: Sequence[Untaken]
    """turns of the knobs that the tracer has not"""

    @property
    def images(self) -> list[PlannedImage]:
        """Renders to be kept."""
        return [*self.seeds, *self.convergence, *self.knobs]

    @property
    def times(self) -> list[PlannedTime]:
        """Renders to be timed."""
        return [*self.timing, *self.packets, *self.engines]

    def left(self, folder: Path, book: TimeBook) -> "Share":
        """What an earlier run has not completed."""
        timed = {row["key"] for row in book.rows}

        def unfinished(images: Sequence[PlannedImage]) -> list[PlannedImage]:
            return [image for image in images if not image_is_finished(folder, image)]

        def untimed(times: Sequence[PlannedTime]) -> list[PlannedTime]:
            return [time for time in times if time.key not in timed]

        return replace(
            self,
            timing=untimed(self.timing),
            seeds=unfinished(self.seeds),
            convergence=unfinished(self.convergence),
            packets=untimed(self.packets),
            engines=untimed(self.engines),
            knobs=unfinished(self.knobs),
        )

    def __len__(self) -> int:
        return len(self.images) + len(self.times)


@dataclass(frozen=True, slots=True)
class ModelJob:
    """Renders what is left of one scene in one model."""

    crew: Crew
    progress: Progress
    book: TimeBook
    folder: Path
    scene_path: Path
    settings: RenderSettings

    def run(self, shares: Sequence[Share]) -> None:
        """Load, warm up, and render, the tracers in turn.

        Tracers with nothing left to do are not loaded.
        """
        loaded: dict[str, Loaded] = {}
        for share in shares:
            if len(share) == 0:
                continue
            tracer = share.subject.tracer
            self.progress.say(f"{self.settings.model} {tracer} loads and warms up")
            answer = self.crew.load(tracer, self.scene_path, self.settings)
            if answer is not None:
                self.book.add_hashes(answer)
                warm = self._warm_up(share)
                loaded[tracer] = replace(answer, times={**answer.times, **warm})
        at_work = [share for share in shares if share.subject.tracer in loaded]
        self._take_times([share.timing for share in at_work], loaded, at_work)
        self._take_images([share.seeds for share in at_work], "seeds")
        self._take_images([share.convergence for share in at_work], "convergence")
        self._take_times([share.packets for share in at_work], loaded, at_work)
        self._take_times([share.engines for share in at_work], loaded, at_work)
        for share in at_work:
            self._warm_up_knobs(share)
        self._take_images([share.knobs for share in at_work], "knobs")

    def _takes_part(self, subject: Subject) -> bool:
        return self.crew.takes_part(subject.tracer, subject.model)

    def _warm_up(self, share: Share) -> dict[str, float]:
        """Render untimed: the first renders compile and fill caches, and they count the rays."""
        subject, ready = share.subject, share.ready
        first = (*share.times, *share.images)[0].request
        # The plain engine renders what the sweeps render, so that their films can be compared.
        plain = [replace(time.request, engine=ready.engines[0], options={}) for time in share.times]
        requests = [*plain, *(time.request for time in share.times)]
        seconds: list[float] = []

        def render(request: Render) -> RenderResult | None:
            if not self._takes_part(subject):
                return None
            result = self.crew.render(subject.tracer, subject.model, request)
            if result is not None:
                seconds.append(result.seconds)
            return result

        for request in requests:
            if self.book.counted(subject, request) is None:
                result = render(replace(request, count_rays=True))
                if result is not None:
                    self.book.add_count(subject, request, result)
        while self._takes_part(subject) and len(seconds) < ready.warm_ups:
            render(first)
        return {"warm_seconds": seconds[0]} if seconds else {}

    def _warm_up_knobs(self, share: Share) -> None:
        """Render each turn untimed, since the seconds of its images count; it may compile anew."""
        turns: dict[Path, Render] = {}
        for image in share.knobs:
            turns.setdefault(image.stem.parent, image.request)
        for request in turns.values():
            for _ in range(share.ready.warm_ups):
                if self._takes_part(share.subject):
                    self.crew.render(share.subject.tracer, share.subject.model, request)

    def _take_images(self, plans: Sequence[Sequence[PlannedImage]], what: str) -> None:
        for image in in_turn(plans):
            subject = image.subject
            if not self._takes_part(subject):
                continue
            stem = self.folder / image.stem
            # The record goes first and comes last: without it the image is not finished.
            stem.with_suffix(".json").unlink(missing_ok=True)
            stem.with_suffix(".npy").unlink(missing_ok=True)
            result = self.crew.render(subject.tracer, subject.model, image.request)
            record = {
                "key": image.key,
                "tracer": subject.tracer,
                "model": subject.model,
                "seed": image.request.seed,
                "spp": image.request.spp,
                "case": dict(image.request.options),
                "rays": None,
            }
            if result is None:
                outcome = {"status": "failed", "note": self.crew.rows[-1]["reason"]}
            else:
                write_image(stem.with_suffix(".npy"), result.image)
                outcome = {
                    "seconds": result.seconds,
                    "film_sha256": result.film_sha256,
                    "status": "ok",
                    "note": "",
                    **result.extras,
                }
            write_json(stem.with_suffix(".json"), {**record, **outcome})
            self.progress.step(subject.model, subject.tracer, what)

    def _take_times(
        self,
        plans: Sequence[Sequence[PlannedTime]],
        loaded: Mapping[str, Loaded],
        shares: Sequence[Share],
    ) -> None:
        precision = {share.subject.tracer: share.ready.precision for share in shares}
        for time in in_turn(plans):
            subject, request = time.subject, time.request
            if not self._takes_part(subject):
                continue
            result = self.crew.render(subject.tracer, subject.model, request)
            if result is None:
                continue
            counted = self.book.counted(subject, request)
            row = {
                "key": time.key,
                "tracer": subject.tracer,
                "model": subject.model,
                "engine": request.engine,
                "precision": precision[subject.tracer],
                "case": dict(request.options),
                "repeat": time.repeat,
                "seed": request.seed,
                "spp": request.spp,
                "seconds": result.seconds,
                "rays": counted["rays"] if counted else None,
                "film_sha256": result.film_sha256,
                "status": "ok",
                "note": "",
            }
            self.book.add({**loaded[subject.tracer].times, **result.extras, **row})
            self.progress.step(subject.model, subject.tracer, _description(request))


def _description(request: Render) -> str:
    options = " ".join(f"{key} {value}" for key, value in request.options.items())
    return f"timing {request.engine} {options}".rstrip()
