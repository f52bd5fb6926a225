"""Haste on the GPU and on the CPU, and Haste's models on Embree's traversal."""

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from harness.scene import RenderSettings, Scene, SceneError, check_model, load_scene, load_settings
from harness.statistics.work_spans import WorkSpan
from harness.tracers.base import NO_OPTIONS, RayCounts, RenderResult, Tracer, UnsupportedError
from harness.tracers.extension import hold, structure_of, traversals
from harness.tracers.rays import NONE, Held, Query, RayHits, Rays, Structure, Visits, Way

MODELS = frozenset({"path", "haste", "whitted"})
SETTINGS = frozenset({"max_depth", "rr_depth", "light_samples", "ambient_samples"})
"""Render settings that a single image may have otherwise."""
IMAGE_HIERARCHIES = ("bvh2", "bvh8")
"""Of small and of large scenes: haste_cuda/engine/schedule.cpp,
`image_traversal`."""
EXTENSION_MISSING = (
    "the compiled extension haste_cuda._core cannot be imported ({reason}); "
    "`./bench setup` builds it"
)


def to_core(scene: Scene, threads: int) -> Any:
    """Convert an imported scene to the extension's, building its BVH.

    Parameters
    ----------
    scene
        The imported scene.
    threads
        Threads of the BVH builder; the tree is the same at any number.

    Returns
    -------
    haste_cuda.Scene
    """
    import haste_cuda

    camera = scene.camera
    return haste_cuda.Scene(
        vertices=scene.vertices,
        normals=scene.normals,
        triangles=scene.triangles,
        triangle_shape=scene.triangle_shape,
        spheres=scene.spheres,
        sphere_shape=scene.sphere_shape,
        shapes=[
            haste_cuda.Shape(
                kind=shape.kind,
                material=shape.material,
                light=shape.light,
                first=shape.first,
                count=shape.count,
                smooth=shape.smooth,
                flip_normals=shape.flip_normals,
            )
            for shape in scene.shapes
        ],
        materials=[
            haste_cuda.Material(
                kind=material.kind,
                diffuse=material.diffuse,
                specular=material.specular,
                ambient=material.ambient,
                exponent=material.exponent,
                reflection=material.reflection,
                transmission=material.transmission,
                ior=material.ior,
                twosided=material.twosided,
            )
            for material in scene.materials
        ],
        lights=[(light.shape, light.radiance) for light in scene.lights],
        camera=haste_cuda.Camera(
            origin=camera.origin,
            corner=camera.corner,
            dx=camera.dx,
            dy=camera.dy,
            near=camera.near,
            width=camera.width,
            height=camera.height,
        ),
        environment=scene.environment,
        threads=threads,
    )


def to_core_settings(settings: RenderSettings, clamp: float = math.inf) -> Any:
    """Convert render settings to the extension's, which takes the model apart from them.

    clamp: in `path`, the largest sum of channels of a contribution of indirect light.
    """
    import haste_cuda

    return haste_cuda.Settings(
        max_depth=settings.max_depth,
        rr_depth=settings.rr_depth,
        max_layers=settings.max_layers,
        light_samples=settings.light_samples,
        ambient_samples=settings.ambient_samples,
        ambient=settings.ambient,
        clamp=clamp,
    )


class _HasteTracer(Tracer):
    """What the three share: import, conversion and the reading of the extension's answer."""

    models: ClassVar[frozenset[str]] = MODELS
    precision: ClassVar[str] = "watertight"
    knobs: ClassVar[frozenset[str]] = SETTINGS | {"clamp"}
    source: tuple[Path, int, int] | None = None
    """Of the scene that is imported: its file, and the size of its images in pixels."""

    @classmethod
    def unavailable(cls) -> str | None:
        try:
            import haste_cuda
        except ImportError as error:
            return EXTENSION_MISSING.format(reason=error)
        del haste_cuda
        return None

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        """Make a scene ready; times and sizes are those of its import, once for all models."""
        source = (scene_path, settings.width, settings.height)
        try:
            if self.source != source:
                self._import(scene_path, settings)
                self.source = source
            check_model(self.imported, settings.model)
        except SceneError as error:
            raise UnsupportedError(str(error)) from error
        self.model = settings.model
        self.settings = settings
        return dict(self.times)

    def _import(self, scene_path: Path, settings: RenderSettings) -> None:
        self.source = None
        start = time.perf_counter()
        recentre = load_settings(scene_path).recentre
        scene = load_scene(
            scene_path, width=settings.width, height=settings.height, recentre=recentre
        )
        loaded = time.perf_counter()
        self.imported = scene
        self.scene = to_core(scene, self.threads)
        self.owners = np.concatenate([scene.triangle_shape, scene.sphere_shape, [NONE]])
        bvh = self.scene.bvh
        self.hashes = {"bvh_sha256": str(bvh["sha256"])}
        self.times = {
            "load_seconds": loaded - start,
            "build_seconds": float(bvh["build_seconds"]),
            "bvh_bytes": float(bvh["bytes"]),
            "bvh_nodes": float(bvh["nodes"]),
            "bvh_depth": float(bvh["depth"]),
        }

    def _trace(self, settings: Any, arguments: dict[str, object]) -> dict[str, Any]:
        import haste_cuda

        return haste_cuda.render_cpu(
            self.scene, self.model, settings, threads=self.threads, **arguments
        )

    def _turned(self, options: Mapping[str, Any]) -> Any:
        """The loaded scene's settings with those of them that the options name."""
        changes = {name: options[name] for name in SETTINGS & options.keys()}
        return to_core_settings(
            replace(self.settings, **changes), float(options.get("clamp", math.inf))
        )

    def render(
        self,
        seed: int,
        spp: int,
        *,
        engine: str = "depth_first",
        options: Mapping[str, object] = NO_OPTIONS,
        count_rays: bool = False,
    ) -> RenderResult:
        counting = {"engine": engine, "count_rays": count_rays}
        rest = {name: options[name] for name in options if name not in SETTINGS | {"clamp"}}
        try:
            answer = self._trace(
                self._turned(options), {"seed": seed, "samples": spp, **counting, **rest}
            )
        except OverflowError as error:
            # The extension knows the pixel, but not what its scene is called.
            raise type(error)(f"{self.imported.name}: {error}") from error
        rays = None
        if count_rays:
            rays = RayCounts(
                camera=int(answer["camera"]),
                shadow=int(answer["shadow"]),
                ambient=int(answer["ambient"]),
                bounce=int(answer["bounce"]),
            )
        names = ("peak_queue_bytes", "non_finite", "launches", "bytes_moved")
        return RenderResult(
            image=answer["film"],
            seconds=float(answer["seconds"]),
            rays=rays,
            film_sha256=answer["film_sha256"],
            extras={name: float(answer[name]) for name in names if name in answer},
            spans=tuple(WorkSpan(*span) for span in answer.get("spans", ())),
        )

    @classmethod
    def ways(cls) -> tuple[Way, ...]:
        """The core's traversals, first the one that is taken where none is named; those of images
        also in fast arithmetic.
        """
        if cls.unavailable() is not None:
            return super().ways()
        names = traversals()
        fast = (Way(name, "fast") for name in names if name in IMAGE_HIERARCHIES)
        return (*(Way(name, cls.precision) for name in names), *fast)

    def structure(self, way: Way) -> Structure | None:
        """The hierarchy of a traversal: what `load` has built, or what the extension says."""
        return structure_of(self.scene, way.traversal)

    def _how(self, way: Way) -> dict[str, object]:
        """Keywords of the extension's replay."""
        return {
            "traversal": way.traversal,
            "precision": way.precision,
            "threads": self.threads,
        }

    def hold(self, rays: Rays) -> Held:
        """Hand rays to the extension."""
        return hold(rays)

    def _trace_rays(self, rays: Held, how: dict[str, object]) -> dict[str, Any]:
        import haste_cuda

        return haste_cuda.trace_cpu(self.scene, rays, **how)

    def replay(self, rays: Held, way: Way, query: Query) -> RayHits:
        """Trace rays on one of the core's traversals."""
        if way not in self.ways():
            raise UnsupportedError(f"{self.name} has no traversal {way.traversal}, {way.precision}")
        return self._hits(self._trace_rays(rays, {**self._how(way), **asdict(query)}))

    def _hits(self, answer: dict[str, Any]) -> RayHits:
        """Read the extension's answer."""
        nothing = np.zeros(0, np.uint32)
        primitive = answer.get("primitive", nothing)
        # No primitive is beyond the last of them, and belongs to no shape.
        shape = self.owners.take(primitive, mode="clip")
        visits = None
        if "nodes" in answer:
            visits = Visits(float(answer["nodes"]), float(answer["triangles"]))
        return RayHits(
            t=answer.get("t", nothing.astype(np.float32)),
            shape=shape,
            primitive=primitive,
            times=tuple(float(seconds) for seconds in answer["seconds"]),
            visits=visits,
            extras={
                name: float(value)
                for name, value in answer.items()
                if name.endswith("_seconds") or name == "registers"
            },
        )


class HasteCpu(_HasteTracer):
    """The core compiled for the CPU, on its own BVH."""

    name: ClassVar[str] = "haste-cpu"
    engines: ClassVar[tuple[str, ...]] = ("depth_first", "packets", "layers")


class Embree(_HasteTracer):
    """The core's models on Embree's traversal, in its robust mode."""

    name: ClassVar[str] = "embree"
    precision: ClassVar[str] = "robust"

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        """Make a scene ready; build time and size are those of Embree's own hierarchy."""
        times = super().load(scene_path, settings)
        built = self.scene.embree
        self.built: dict[str, Structure] = {}
        return {
            "load_seconds": times["load_seconds"],
            "build_seconds": float(built["build_seconds"]),
            "bvh_bytes": float(built["bytes"]),
        }

    def _trace(self, settings: Any, arguments: dict[str, object]) -> dict[str, Any]:
        return super()._trace(settings, {**arguments, "intersector": "embree"})

    @classmethod
    def ways(cls) -> tuple[Way, ...]:
        """Calls of a ray, or of a packet of rays, in both of Embree's modes."""
        return tuple(
            Way(f"intersect{width}", mode) for mode in ("robust", "fast") for width in (1, 8, 16)
        )

    def structure(self, way: Way) -> Structure | None:
        """Embree's own hierarchy, of a mode in which rays have been traced."""
        return self.built.get(way.precision)

    def replay(self, rays: Held, way: Way, query: Query) -> RayHits:
        """Trace rays by one of Embree's calls, which does not say what it looks at."""
        import haste_cuda

        if way not in self.ways():
            raise UnsupportedError(f"{self.name} has no call {way.traversal}, {way.precision}")
        try:
            answer = haste_cuda.trace_embree(
                self.scene,
                rays,
                any_hit=query.any_hit,
                width=int(way.traversal.removeprefix("intersect")),
                mode=way.precision,
                threads=self.threads,
                repeats=query.repeats,
                hits=query.hits,
            )
        except ValueError as refusal:
            # The rays have been checked: what is refused is the packet.
            raise UnsupportedError(str(refusal)) from refusal
        size, seconds = float(answer["bytes"]), float(answer.pop("build_seconds"))
        self.built[way.precision] = Structure(seconds, size)
        return self._hits(answer)


class HasteCuda(_HasteTracer):
    """The core compiled at run time for the GPU."""

    name: ClassVar[str] = "haste-cuda"
    on_gpu: ClassVar[bool] = True
    engines: ClassVar[tuple[str, ...]] = (
        *("depth_first", "packets", "streams"),
        *("layers", "wavefront", "persistent"),
    )
    knobs: ClassVar[frozenset[str]] = SETTINGS | {"clamp", "film"}

    @classmethod
    def unavailable(cls) -> str | None:
        """Also where there is no usable GPU or NVRTC."""
        reason = super().unavailable()
        if reason is not None:
            return reason
        import haste_cuda

        return haste_cuda.cuda_unavailable()

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        """Make a scene ready on the GPU: one sample compiles the kernel and uploads the scene."""
        times = super().load(scene_path, settings)
        first = self._trace(to_core_settings(settings), {"seed": 0, "samples": 1})
        split = {name: float(first[name]) for name in ("compile_seconds", "upload_seconds")}
        return {**times, **split}

    def _trace(self, settings: Any, arguments: dict[str, object]) -> dict[str, Any]:
        import haste_cuda

        return haste_cuda.render_cuda(self.scene, self.model, settings, **arguments)

    def _how(self, way: Way) -> dict[str, object]:
        return {"traversal": way.traversal, "precision": way.precision}

    def _trace_rays(self, rays: Held, how: dict[str, object]) -> dict[str, Any]:
        import haste_cuda

        return haste_cuda.trace_cuda(self.scene, rays, **how)
