"""The benchmark of rays on one scene: rays are made once, and every tracer traces them in turn.

A class of rays is one file of results, which is complete or not there. A job that was interrupted
goes on with the classes that are missing.
"""

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.eye_rays import Seen
from harness.measure.config import Config
from harness.measure.counters import read_clocks
from harness.measure.crew import Crew, NoHits
from harness.measure.eye_rays import unshaded_settings
from harness.measure.files import find_record, hash_files, key_of, write_json
from harness.measure.messages import Ready, Replay, Replayed, Take, Trace
from harness.measure.progress import Stages
from harness.measure.provenance import tracer_code
from harness.measure.ray_variants import Variant
from harness.measure.scene_job import SceneJob, scene_job
from harness.rays.agreement import Sight, compare, evenly
from harness.rays.classes import CLASSES
from harness.rays.generate import RaysError, generate_rays
from harness.rays.store import hash_file, read_rays, write_rays
from harness.scene import RenderSettings, Scene
from harness.tracers.rays import RayHits, Rays, Way
from harness.tracers.registry import TRACERS, load_tracer

ROOT = Path(__file__).resolve().parents[2]
SUMMARY = "replayed.json"
"""Written last: that it is there says that every class is."""
FILE = "rays.npz"
MAKER = "haste-cpu"
"""Finds the hits from which rays go on; everybody is given the same rays."""
SETTLING = 1
"""Untimed repeats at each turn: others have had the caches and the clocks since."""
MOST_REPEATS = 100_000
"""Of a reading of energy, where a repeat takes next to no time."""
OWN_CODE = (
    *("harness/measure/rays.py", "harness/measure/ray_variants.py", "harness/measure/replay.py"),
    *("harness/eye_rays.py",),
    *("harness/tracers/extension.py", "harness/tracers/mitsuba_rays.py", "harness/tracers/rays.py"),
    *("harness/rays/agreement.py", "reference/brute_force.py"),
)


@dataclass(frozen=True, slots=True)
class _Truth:
    """What a sample of the rays hits: of those that are clear, and how many are what."""

    sight: Sight
    sample: int
    ambiguous: int
    hits: int


def replay_scene(config: Config, name: str, threads: int) -> Path:
    """Make the rays of a scene, trace them with every tracer, and compare what they saw.

    Parameters
    ----------
    config
        The run's settings.
    name
        One of the scenes of its section `rays`.
    threads
        Processor threads of every tracer; one tracer traces at a time.

    Returns
    -------
    Path
        The summary, written last.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported.
    RaysError
        Its rays cannot be made.
    """
    with scene_job(config, config.ray_scenes[name], config.ray_dir(name), "rays", threads) as job:
        return _replay(job, name)


def _replay(job: SceneJob, name: str) -> Path:
    config, scene = job.config, job.scene
    render = unshaded_settings(job.settings, scene.camera.width, scene.camera.height)
    tracers = config["tracers"]
    with job.crew({*tracers, MAKER}) as crew:
        ready = crew.ready(dict.fromkeys([*tracers, MAKER]), job.path, render)
        on_gpu = any(ready[tracer].on_gpu for tracer in tracers if tracer in ready)
        count = config["rays"]["count"]["gpu" if on_gpu else "cpu"]
        sha256 = _make_rays(job, crew, count)
        job.note_provenance(rays={"sha256": sha256, "count": count})
        job.describe(
            triangles=len(scene.triangles),
            spheres=len(scene.spheres),
            classes=config["rays"]["classes"],
            rays=count,
            rays_sha256=sha256,
        )
        job.progress.say(f"{count} rays of each class, {len(ready)} tracers, {job.threads} threads")
        subjects = {tracer: job.subject(tracer, render).key for tracer in tracers}
        _Replays(job, crew, render, ready, subjects, count, sha256).run()
    elapsed = job.progress.elapsed
    job.progress.say(f"rays complete in {elapsed:.0f} s")
    return job.finish(SUMMARY, scene=name, seconds=elapsed, failed=crew.failed)


def _make_rays(job: SceneJob, crew: Crew, count: int) -> str:
    """Write the scene's rays, unless they are there; SHA-256 of the file."""
    scene, path, note = job.scene, job.folder / FILE, job.folder / "rays.json"
    inside, seed = job.settings.rays_inside, job.config["rays"]["seed"]
    code = hash_files((ROOT / "harness" / "rays").glob("*.py"))
    parts = {"scene": scene.sha256, "count": count, "seed": seed, "inside": inside}
    key = key_of({**parts, "code": code, "maker": tracer_code(MAKER)})
    known = find_record(note, key)
    if known is not None and path.is_file():
        return str(known["sha256"])
    stages = Stages()

    def trace(rays: Rays) -> RayHits:
        request = Trace(rays.origins, rays.directions, rays.t_min, rays.t_max)
        with stages("tracing"):
            hits = crew.trace_loaded(MAKER, request)
        if isinstance(hits, NoHits):
            raise RaysError(f"{scene.name}: {MAKER} cannot make the rays: {hits.reason}")
        return hits

    if not crew.takes_part(MAKER, unshaded_settings(job.settings, 1, 1).model):
        reasons = [row["reason"] for row in crew.rows if row["tracer"] == MAKER]
        raise RaysError(f"{scene.name}: {MAKER} cannot make the rays: {'; '.join(reasons)}")
    with stages("making"):
        rays = generate_rays(scene, trace, count, seed=seed, inside=inside, threads=crew.threads)
    stages.seconds["making"] -= stages.seconds["tracing"]
    with stages("writing"):
        write_rays(path, rays)
    with stages("hashing"):
        sha256 = hash_file(path)
    write_json(note, {**parts, "key": key, "sha256": sha256, "bytes": path.stat().st_size})
    job.progress.say(f"rays made in {stages}")
    return sha256


@dataclass(frozen=True, slots=True)
class _Replays:
    """The replays of one scene."""

    job: SceneJob
    crew: Crew
    render: RenderSettings
    ready: Mapping[str, Ready]
    subjects: Mapping[str, str]
    count: int
    sha256: str

    @property
    def _settings(self) -> Mapping[str, Any]:
        return self.job.config["rays"]

    @property
    def _scene(self) -> Scene:
        return self.job.scene

    @property
    def _file(self) -> Path:
        return self.job.folder / FILE

    @property
    def _primitives(self) -> int:
        return len(self._scene.triangles) + len(self._scene.spheres)

    def run(self) -> None:
        """Replay every class that an earlier run has not completed."""
        changing = {name: self._settings[name] for name in self._settings if name != "classes"}
        code = hash_files(ROOT / file for file in OWN_CODE)
        parts = {"settings": changing, "code": code, "rays": self.sha256, "who": self.subjects}
        for name in self._settings["classes"]:
            path = self.job.folder / f"{name}.json"
            key = key_of({**parts, "class": name})
            if find_record(path, key) is not None:
                continue
            stages = Stages()
            write_json(path, {"key": key, **self._replay_class(name, stages)})
            self.job.progress.say(f"{name} in {stages}")

    def _variants(self) -> list[Variant]:
        """Every tracer in every way that is asked for, also those that cannot."""
        variants = []
        for tracer in self.job.config["tracers"]:
            answer = self.ready.get(tracer)
            if answer is None or not self.crew.takes_part(tracer, self.render.model):
                missing = Variant(tracer, Way("", load_tracer(TRACERS[tracer]).precision))
                missing.end(self.crew.absence(tracer))
                variants.append(missing)
                continue
            wanted = self._settings["traversals"]
            ways = [way for way in answer.ways if way.traversal in ("", *wanted)]
            variants += [self._variant(tracer, way, on_gpu=answer.on_gpu) for way in ways]
        return variants

    def _variant(self, tracer: str, way: Way, *, on_gpu: bool) -> Variant:
        limits = [self._settings["most"].get(tracer)]
        if way.traversal == "brute_force":
            tests = self._settings["most_tests"]["gpu" if on_gpu else "cpu"]
            # A power of two, so that the rays of the sample are among them.
            limits.append(2 ** int(math.log2(max(1, tests // self._primitives))))
        return Variant(tracer, way, min((limit for limit in limits if limit), default=None))

    def _replay_class(self, name: str, stages: Stages) -> dict[str, Any]:
        variants = self._variants()
        clocks = [read_clocks()]
        with stages("reading"):
            true = self._read(name, variants)
        with stages("looking"):
            for variant in variants:
                self._look(name, variant)
        with stages("comparing"):
            apart = self._compare(name, true.sight, variants)
        with stages("timing"):
            self._take_times(name, variants)
        clocks.append(read_clocks())
        with stages("energy"):
            for variant in variants:
                self._take_energy(name, variant)
        rows = [{**one.row(), **what} for one, what in zip(variants, apart, strict=True)]
        return {
            "rays": name,
            "any_hit": CLASSES[name],
            "count": self.count,
            "clocks": clocks,
            "sample": true.sample,
            "ambiguous": true.ambiguous,
            "hits": true.hits,
            "variants": rows,
        }

    def _ask(self, name: str, variant: Variant, **how: Any) -> Replayed | None:
        """One request to a variant that can still be asked; None, and the reason noted, if not."""
        if variant.status != "ok":
            return None
        if not self.crew.takes_part(variant.tracer, self.render.model):
            variant.end(self.crew.absence(variant.tracer))
            return None
        request = Replay(
            file=self._file,
            rays=name,
            any_hit=CLASSES[name],
            way=variant.way,
            most=variant.most,
            **how,
        )
        answer = self.crew.replay(variant.tracer, self.render.model, request)
        if isinstance(answer, NoHits):
            variant.end(answer)
            return None
        return answer

    def _look(self, name: str, variant: Variant) -> None:
        """Trace to see what is hit, and so often that what follows is warm."""
        answer = self._ask(name, variant, hits=True, repeats=self._settings["warm_ups"])
        if answer is None or answer.t is None or answer.primitive is None:
            return
        variant.first, variant.rays = answer, answer.rays
        places = evenly(self.count, variant.most or self.count)
        variant.sight = Sight(places, Seen(answer.t, answer.primitive))

    def _read(self, name: str, variants: Sequence[Variant]) -> _Truth:
        """Have every tracer read the rays, all at once, and find what some of them hit meanwhile.

        Nothing is built or timed yet that this would disturb.
        """
        most: dict[str, list[int | None]] = {}
        for variant in variants:
            if variant.status == "ok":
                most.setdefault(variant.tracer, []).append(variant.most)

        def take(tracer: str) -> None:
            request = Take(self._file, name, tuple(dict.fromkeys(most[tracer])))
            self.crew.take(tracer, self.render.model, request)

        with ThreadPoolExecutor(len(most) + 1) as pool:
            truth = pool.submit(self._truth, name)
            for taken in [pool.submit(take, tracer) for tracer in most]:
                taken.result()
            return truth.result()

    def _truth(self, name: str) -> _Truth:
        """What some of the rays hit, in double precision."""
        from reference.brute_force import closest_hits

        rays = read_rays(self._file, name)
        wanted = min(self._settings["sample"], self._settings["sample_pairs"] // self._primitives)
        places = evenly(len(rays), max(1, wanted))
        sample = Rays(*(getattr(rays, part)[places] for part in Rays.__slots__))
        truth = closest_hits(self._scene, sample)
        clear = ~truth.ambiguous
        return _Truth(
            sight=Sight(places[clear], Seen(truth.t[clear], truth.primitive[clear])),
            sample=len(sample),
            ambiguous=int(truth.ambiguous.sum()),
            hits=int(np.isfinite(truth.t).sum()),
        )

    def _compare(
        self, name: str, exact: Sight, variants: Sequence[Variant]
    ) -> list[dict[str, Any]]:
        """What differs from double precision, and from the first way of every tracer."""
        leaders: dict[str, Variant] = {}
        for variant in variants:
            if variant.sight is not None:
                leaders.setdefault(variant.tracer, variant)
        any_hit = CLASSES[name]

        def judge(variant: Variant) -> dict[str, Any]:
            if variant.sight is None:
                return {}
            others = {
                tracer: compare(*variant.sight.both(other.sight), any_hit=any_hit)
                for tracer, other in leaders.items()
                if other is not variant and other.sight is not None
            }
            judged = compare(*variant.sight.both(exact), any_hit=any_hit)
            return {
                "wrong": asdict(judged),
                "differing": {tracer: asdict(share) for tracer, share in others.items()},
            }

        # Millions of rays and a pair of tracers at a time: numpy lets go of the interpreter's lock.
        with ThreadPoolExecutor(self.crew.threads) as pool:
            return list(pool.map(judge, variants))

    def _take_times(self, name: str, variants: Sequence[Variant]) -> None:
        """Timed repeats, the variants in turn: A B C A B C."""
        timed = [
            variant
            for variant in variants
            if variant.first is not None and math.isfinite(variant.first.times[-1])
        ]
        left = self._settings["repeats"]
        while left > 0:
            now = min(left, self._settings["at_once"])
            for variant in timed:
                answer = self._ask(name, variant, repeats=SETTLING + now)
                if answer is not None:
                    variant.times += answer.times[SETTLING:]
            left -= now

    def _take_energy(self, name: str, variant: Variant) -> None:
        """Read the GPU's counter around so many repeats that it moves."""
        energy = self._settings["energy"]
        if name not in energy["classes"] or not variant.times or variant.status != "ok":
            return
        if not self.ready[variant.tracer].on_gpu:
            variant.energy_reason = "traces on the processor; NVML counts the energy of a GPU"
            return
        repeats = math.ceil(energy["seconds"] / float(np.median(variant.times)))
        answer = self._ask(name, variant, repeats=min(repeats, MOST_REPEATS), energy=True)
        if answer is None:
            return
        if isinstance(answer.joules, str):
            variant.energy_reason = answer.joules
        else:
            variant.joules = answer.joules
