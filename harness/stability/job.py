"""The cracks of one mesh: the same rays through every tracer, at every scale and eye.

What comes of one scale is one file of results, which is complete or not there.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from harness.measure.config import Config
from harness.measure.crew import Crew, NoHits
from harness.measure.eye_rays import unshaded_settings
from harness.measure.files import find_record, hash_files, key_of, write_json
from harness.measure.messages import Ready, Replay
from harness.measure.progress import Progress
from harness.measure.provenance import tracer_code
from harness.measure.scene_job import SceneJob, scene_job
from harness.rays.agreement import evenly
from harness.rays.store import write_rays
from harness.scene import RenderSettings, load_settings
from harness.stability.aims import AIMS, Mesh, aimed_rays
from harness.stability.cracks import QUANTILES, Truth, distance_errors, false_hits, lost, truth_of
from harness.stability.mesh_scene import largest_mesh, scaled, write_mesh_scene
from harness.stability.rings import Integers, Rings, edge_rings, vertex_rings
from harness.tracers.rays import Rays, Way
from harness.tracers.registry import TRACERS, load_tracer

ROOT = Path(__file__).resolve().parents[2]
SUMMARY = "stability.json"
"""Written last: that it is there says that every scale is."""
CLASS = "aimed"
AT_ONCE = 1 << 20
"""Rays that are made, traced and judged together: what bounds the memory."""
MOST_ERRORS = 1 << 16
"""Rays whose distances are compared."""
COUNTS = ("rays", "met", "judged", "lost", "at_outline", "hits", "denied")


@dataclass(slots=True)
class Variant:
    """One tracer in one way; what came of it for one aim, scale and eye."""

    tracer: str
    way: Way
    most: int | None = None
    status: str = "ok"
    reason: str = ""
    counts: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTS, 0))
    first: dict[str, list[float]] | None = None
    """the first lost ray"""
    ulp: list[float] | None = None
    """quantiles `QUANTILES` of the error of the distance, of the rays that are traced first"""


@dataclass(frozen=True, slots=True)
class Aimed:
    """Some rays, what they are aimed at and what they meet."""

    file: Path
    mesh: Mesh
    rings: Rings
    rays: Rays
    ring: Integers
    truth: Truth


def measure_stability(config: Config, name: str, threads: int) -> Path:
    """Aim rays at a mesh's edges and vertices, and count those that each tracer loses.

    Parameters
    ----------
    config
        The run's settings.
    name
        One of the scenes of its section `stability`, of which the largest mesh is taken.
    threads
        Processor threads of every tracer; one tracer traces at a time.

    Returns
    -------
    Path
        The summary, written last.

    Raises
    ------
    harness.scene.SceneError
        The scene cannot be imported, or has no mesh.
    """
    path, folder = config.stability_scenes[name], config.stability_dir(name)
    with scene_job(config, path, folder, "stability", threads) as job:
        return _measure(job, name)


def _measure(job: SceneJob, name: str) -> Path:
    config, folder, settings = job.config, job.folder, job.config["stability"]
    vertices, triangles = largest_mesh(job.scene)
    job.note_provenance()
    code = hash_files(
        [*(ROOT / "harness" / "stability").glob("*.py"), ROOT / "reference" / "exact_hits.py"]
    )
    who = {tracer: tracer_code(tracer) for tracer in config["tracers"]}
    failed: list[dict[str, str]] = []
    for scale in settings["scales"]:
        path = folder / f"scale-{scale:g}.json"
        parts = {"scene": job.scene.sha256, "settings": settings, "scale": scale}
        key = key_of({**parts, "code": code, "who": who, "threads": job.threads})
        if find_record(path, key) is not None:
            continue
        mesh = Mesh.of(scaled(vertices, scale), triangles)
        place = write_mesh_scene(folder / f"scale-{scale:g}", mesh.vertices, triangles)
        with job.crew(config["tracers"]) as crew:
            rows = _Aims(config, crew, mesh, place, folder).run(job.progress, scale)
            write_json(path, {"key": key, "scale": scale, "rows": rows})
            failed += crew.failed
    description = {"scene": name, "triangles": len(triangles), "scales": settings["scales"]}
    elapsed = job.progress.elapsed
    job.progress.say(f"stability complete in {elapsed:.0f} s")
    return job.finish(SUMMARY, **description, seconds=elapsed, failed=failed)


@dataclass(frozen=True, slots=True)
class _Aims:
    """The rays at one mesh."""

    config: Config
    crew: Crew
    mesh: Mesh
    place: Path
    folder: Path

    @property
    def _settings(self) -> Mapping[str, Any]:
        return self.config["stability"]

    @property
    def _render(self) -> RenderSettings:
        return unshaded_settings(load_settings(self.place), 1, 1)

    def run(self, progress: Progress, scale: float) -> list[dict[str, Any]]:
        """Trace and judge; a row for each tracer, way, aim and eye."""
        render = self._render
        ready = self.crew.ready(self.config["tracers"], self.place, render)
        edges = edge_rings(self.mesh.vertices, self.mesh.triangles)
        corners = vertex_rings(self.mesh.vertices, self.mesh.triangles)
        rows = []
        for aim in AIMS:
            rings = edges if "edge" in aim else corners
            for eye in self._settings["eyes"]:
                variants = self._variants(ready)
                for aimed in self._rays(rings, aim, eye):
                    for variant in variants:
                        self._judge(variant, aimed, render.model)
                    aimed.file.unlink()
                case = {"aim": aim, "scale": scale, "eye": eye}
                rows += [{**case, **_row(variant)} for variant in variants]
            progress.say(f"scale {scale:g}, {aim}")
        return rows

    def _rays(self, rings: Rings, aim: str, eye: float) -> Iterator[Aimed]:
        """The rays of one aim and eye, in parts; every part has random numbers of its own.

        Also a file of its own: tracers keep the rays of the last file that they have read.
        """
        left, part = self._settings["count"], 0
        while left > 0 and len(rings):
            key = [self._settings["seed"], AIMS.index(aim), part]
            random = np.random.default_rng(key)
            count, beside = min(left, AT_ONCE), aim.startswith("beside")
            rays, ring = aimed_rays(self.mesh, rings, count, eye=eye, beside=beside, random=random)
            file = self.folder / f"rays-{aim}-{eye:g}-{part}.npz"
            write_rays(file, {CLASS: rays})
            yield Aimed(file, self.mesh, rings, rays, ring, truth_of(self.mesh, rings, rays, ring))
            left, part = left - count, part + 1

    def _variants(self, ready: Mapping[str, Ready]) -> list[Variant]:
        """Every tracer in every way that is asked for, also those that cannot."""
        variants = []
        for tracer in self.config["tracers"]:
            answer = ready.get(tracer)
            if answer is None or not self.crew.takes_part(tracer, self._render.model):
                way = Way("", load_tracer(TRACERS[tracer]).precision)
                variants.append(Variant(tracer, way, **asdict(self.crew.absence(tracer))))
                continue
            for way in answer.ways:
                if way.traversal in ("", *self._settings["traversals"]):
                    most = self._most(tracer, way, on_gpu=answer.on_gpu)
                    variants.append(Variant(tracer, way, most))
        return variants

    def _most(self, tracer: str, way: Way, *, on_gpu: bool) -> int | None:
        """Most rays of a part for a slow tracer, or a slow way."""
        limits = [self._settings["most"].get(tracer)]
        if way.traversal == "brute_force":
            tests = self.config["rays"]["most_tests"]["gpu" if on_gpu else "cpu"]
            limits.append(2 ** int(math.log2(max(1, tests // len(self.mesh.triangles)))))
        return min((limit for limit in limits if limit), default=None)

    def _judge(self, variant: Variant, aimed: Aimed, model: str) -> None:
        """Trace a part in one way, and count."""
        if variant.status != "ok":
            return
        request = Replay(
            file=aimed.file,
            rays=CLASS,
            any_hit=False,
            way=variant.way,
            most=variant.most,
            hits=True,
        )
        answer = self.crew.replay(variant.tracer, model, request)
        if isinstance(answer, NoHits):
            variant.status, variant.reason = answer.status, answer.reason
            return
        if answer.t is None or answer.primitive is None:
            return
        part = evenly(len(aimed.rays), variant.most or len(aimed.rays))
        rays = Rays(*(getattr(aimed.rays, name)[part] for name in Rays.__slots__))
        truth = Truth(*(getattr(aimed.truth, name)[part] for name in Truth.__slots__))
        gone = lost(aimed.rings, aimed.ring[part], truth, answer.t, answer.primitive)
        cracks = gone & truth.covered
        found = {
            "rays": len(rays),
            "met": truth.met.sum(),
            "judged": truth.covered.sum(),
            "lost": cracks.sum(),
            "at_outline": (gone & ~truth.covered).sum(),
            "hits": np.isfinite(answer.t).sum(),
            "denied": false_hits(aimed.mesh, rays, answer.t, answer.primitive).sum(),
        }
        for name, count in found.items():
            variant.counts[name] += int(count)
        if variant.ulp is None and np.isfinite(answer.t).any():
            some = slice(0, MOST_ERRORS)
            few = Rays(*(getattr(rays, name)[some] for name in Rays.__slots__))
            errors = distance_errors(aimed.mesh, few, answer.t[some], answer.primitive[some])
            errors = errors[np.isfinite(errors)]
            variant.ulp = np.quantile(errors, QUANTILES).tolist() if len(errors) else None
        if cracks.any() and variant.first is None:
            place = int(np.argmax(cracks))
            variant.first = {
                "origin": rays.origins[place].tolist(),
                "direction": rays.directions[place].tolist(),
            }


def _row(variant: Variant) -> dict[str, Any]:
    return {
        "tracer": variant.tracer,
        **asdict(variant.way),
        "status": variant.status,
        "reason": variant.reason,
        **variant.counts,
        "first": variant.first,
        "ulp": variant.ulp,
    }
