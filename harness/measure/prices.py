"""What features cost: one scene's kernels with exactly what it requires, with one feature more, and
with all.

Kernels are compiled on any machine that has NVRTC, and timed where there is a GPU. A job that was
interrupted goes on with the rows that are missing.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from harness.measure.config import Config, ConfigError
from harness.measure.crew import Crew
from harness.measure.files import find_record, key_of, write_json
from harness.measure.kernels import KernelCost, Program, measure_kernel
from harness.measure.messages import Render
from harness.measure.plan import in_turn
from harness.measure.scene_job import SceneJob, scene_job
from harness.scene import RenderSettings

SUMMARY = "priced.json"
"""Written last: that it is there says that every price is known."""
SHELF = "kernels"
"""Folder of what kernels took to compile, which scenes share."""
REQUIRED, ALL, EVERY = "required", "all", "every"
PRIMITIVES = ("triangles", "spheres")
"""The features by which programs of the processor differ."""
SEED = 0

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Priced:
    """A set of features, as the tables name it, and its bits."""

    name: str
    features: int


@dataclass(frozen=True, slots=True)
class Needs:
    """What a scene requires in a model: bits of features, and the settings of its images."""

    model: str
    required: int
    of_model: int
    settings: RenderSettings
    traversal: str
    core_settings: Any

    def cases(self, names: Sequence[str], singly: Sequence[str]) -> list[Priced]:
        """Required, one more each, and all; a feature that the model has no code for is left out.

        names: of the features, in the order of their bits. singly: those that are added one by one.
        """
        cases = [Priced(REQUIRED, self.required)]
        for bit, name in enumerate(names):
            more = 1 << bit
            if name in singly and more & self.of_model and not more & self.required:
                cases.append(Priced(f"{REQUIRED}+{name}", self.required | more))
        return [*cases, Priced(ALL, self.required | self.of_model)]


def price_scene(config: Config, name: str, threads: int) -> Path:
    """Compile and time a scene's programs with the features that it requires, and with more.

    Parameters
    ----------
    config
        The run's settings; its section `features` says what is priced.
    name
        One of `config.price_scenes`.
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
    ConfigError
        The settings name a feature that there is not.
    """
    path, folder = config.price_scenes[name], config.price_dir(name)
    with scene_job(config, path, folder, "prices", threads) as job:
        return _Prices(job).run(name)


class _Prices:
    """The prices of one scene."""

    def __init__(self, job: SceneJob) -> None:
        from haste_cuda import _core
        from haste_cuda.nvrtc import configure

        configure()
        self.core = _core
        self.job, self.progress = job, job.progress
        self.settings: dict[str, Any] = job.config["features"]
        self.names: list[str] = _core.feature_names()
        self.singly = self._singly()

    def _singly(self) -> list[str]:
        chosen = self.settings["singly"]
        if chosen == EVERY:
            return self.names
        unknown = [name for name in chosen if name not in self.names]
        if unknown:
            raise ConfigError(
                f"config: features.singly: there is no feature {unknown[0]!r}; "
                f"the features are {', '.join(self.names)}"
            )
        return list(chosen)

    def run(self, name: str) -> Path:
        """Compile, then time; write what came of it."""
        needs = self._needs()
        architecture, gpu = self._architecture()
        compiled = [row for need in needs for row in self._compile(need, architecture)]
        timed, failed = self._time(needs)
        self.job.describe(
            architecture=architecture,
            gpu=gpu,
            required={need.model: self._spelled(need.required) for need in needs},
            ray_bytes=int(self.core.ray_bytes()),
        )
        self.job.note_provenance()
        write_json(self.job.folder / "compiled.json", compiled)
        seconds = self.progress.elapsed
        self.progress.say(f"{len(compiled)} kernels, {len(timed)} times in {seconds:.0f} s")
        return self.job.finish(SUMMARY, scene=name, seconds=seconds, failed=failed)

    def _spelled(self, features: int) -> list[str]:
        return [name for bit, name in enumerate(self.names) if features >> bit & 1]

    def _needs(self) -> list[Needs]:
        from harness.tracers.haste import to_core, to_core_settings

        core_scene = to_core(self.job.scene, self.job.threads)
        traversal = self.core.image_traversal(core_scene, self.settings["engine"])
        needs = []
        for model in self.settings["models"]:
            if model not in self.job.settings.models:
                continue
            render = self.job.settings.render(model)
            values = to_core_settings(render)
            required = int(self.core.required_features(core_scene, model, values))
            of_model = int(self.core.model_features(model))
            needs.append(Needs(model, required, of_model, render, traversal, values))
        return needs

    def _architecture(self) -> tuple[int, str]:
        """The GPU's architecture and name; without one that of the settings."""
        import haste_cuda

        if haste_cuda.cuda_unavailable() is not None:
            return int(self.settings["architecture"]), ""
        info = haste_cuda.device_info()
        major, minor = info["compute_capability"]
        return 10 * int(major) + int(minor), str(info["name"])

    def _compile(self, need: Needs, architecture: int) -> list[Row]:
        """One row a set of features: what its kernel takes, or why that is not known."""
        reason = self.core.nvrtc_unavailable()
        rows = []
        for case in need.cases(self.names, self.singly):
            row: Row = {"model": need.model, "features": case.name, "bits": case.features}
            if reason is not None:
                rows.append({**row, "status": "skipped", "reason": reason})
                continue
            stack = int(self.core.stack_capacity(need.model, need.core_settings, case.features))
            program = Program(
                kernel=self.settings["engine"],
                model=need.model,
                precision="watertight",
                features=case.features,
                stack=stack,
                traversal=need.traversal,
                architecture=architecture,
            )
            cost = self._measured(program)
            rows.append({**row, "status": "ok", "reason": "", **asdict(cost)})
            self.progress.hint(f"compiled {need.model} {case.name}")
        return rows

    def _measured(self, program: Program) -> KernelCost:
        shelf = self.job.folder.parent / f".{SHELF}"
        return measure_kernel(program, self.settings["compile_repeats"], shelf)

    def _time(self, needs: Sequence[Needs]) -> tuple[list[Row], list[Row]]:
        """Time every tracer's programs, each once before any of them again; all rows, and those of
        tracers that failed.
        """
        path = self.job.folder / "timed.json"
        tracers = [name for name in self.settings["tracers"] if name in self.job.config["tracers"]]
        rows: list[Row] = []
        with self.job.crew(tracers) as crew:
            for need in needs:
                for tracer, ready in crew.probe(tracers, need.model).items():
                    rows += self._time_one(crew, need, tracer, on_gpu=ready.on_gpu)
        for need in needs:
            for row in crew.rows:
                if row["model"] == need.model:
                    cases = self._cases_of(need, row["tracer"])
                    rows += [{**row, "features": case.name, "seconds": []} for case in cases]
        write_json(path, rows)
        return rows, crew.failed

    def _cases_of(self, need: Needs, tracer: str) -> list[Priced]:
        """The sets of features that a tracer has programs for."""
        cases = need.cases(self.names, self.singly)
        if tracer == "haste-cuda":
            return cases
        # Programs of the processor differ in the kinds of primitives.
        kinds = sum(1 << self.names.index(name) for name in PRIMITIVES)
        return [
            case
            for case in cases
            if case.name in {REQUIRED, ALL} or case.features & ~need.required & kinds
        ]

    def _time_one(self, crew: Crew, need: Needs, tracer: str, *, on_gpu: bool) -> list[Row]:
        subject = self.job.subject(tracer, need.settings)
        samples = self.settings["samples"]["gpu" if on_gpu else "cpu"]
        pixels = need.settings.width * need.settings.height
        spp = max(1, math.ceil(samples / pixels))
        cases = self._cases_of(need, tracer)
        key = key_of(
            {"subject": subject.key, "spp": spp, "cases": [asdict(case) for case in cases]}
            | {"repeats": self.settings["repeats"], "engine": self.settings["engine"]}
        )
        saved = self.job.folder / f"{need.model}-{tracer}.json"
        known = find_record(saved, key)
        if known is not None:
            return list(known["rows"])
        if crew.load(tracer, self.job.path, need.settings) is None:
            return []
        requests = {
            case: Render(
                seed=SEED,
                spp=spp,
                engine=self.settings["engine"],
                options={"more_features": case.features},
            )
            for case in cases
        }
        found = self._take(crew, need.model, tracer, requests)
        if found is None:
            return []
        rows: list[Row] = [
            {"model": need.model, "tracer": tracer, "features": case.name, "status": "ok"}
            | {"reason": "", "spp": spp, "samples": spp * pixels, "on_gpu": on_gpu}
            | taken
            for case, taken in found.items()
        ]
        write_json(saved, {"key": key, "rows": rows})
        return rows

    def _take(
        self, crew: Crew, model: str, tracer: str, requests: Mapping[Priced, Render]
    ) -> dict[Priced, Row] | None:
        """One warm-up each, and then the timed renders in turn; None where one fails."""
        taken: dict[Priced, Row] = {}
        for case, request in requests.items():
            result = crew.render(tracer, model, request)
            if result is None:
                return None
            taken[case] = {"seconds": [], "film_sha256": result.film_sha256}
        for case in in_turn([[case] * self.settings["repeats"] for case in requests]):
            result = crew.render(tracer, model, requests[case])
            if result is None:
                return None
            taken[case]["seconds"].append(result.seconds)
            self.progress.hint(f"{model} {tracer} {case.name}")
        return taken
