"""Mitsuba's native path tracer on its three back ends: LLVM, OptiX and scalar C++."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.scene import RenderSettings, Scene, SceneError, load_scene, parse_scene
from harness.tracers.base import NO_OPTIONS, RenderResult, Tracer, UnsupportedError
from harness.tracers.rays import NONE, Held, Query, RayHits, Rays, Way

PYTHON_PLUGINS = frozenset({"phong"})
"""Plugins that the project registers from Python; the scalar variants do not run them reliably."""


class _MitsubaTracer(Tracer):
    """One variant of Mitsuba.

    Only `path` is compared: the registered integrators of the other models choose branches at
    random, so their rays and variance are not those of the models.
    """

    models: ClassVar[frozenset[str]] = frozenset({"path"})
    precision: ClassVar[str] = "native"
    warm_ups: ClassVar[int] = 2
    knobs: ClassVar[frozenset[str]] = frozenset({"max_depth", "rr_depth"})
    variant: ClassVar[str]

    @classmethod
    def unavailable(cls) -> str | None:
        try:
            from reference import mitsuba as reference
        except ImportError as error:
            return f"Mitsuba cannot be imported ({error}); `./bench setup` installs it"
        return reference.available(cls.variant)

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        if settings.model not in self.models:
            raise UnsupportedError(f"{self.name} is compared in the path model only")
        from reference import mitsuba as reference

        # reference.available, not this import, decides which LLVM library Dr.Jit loads.
        reason = reference.available(self.variant)
        if reason is not None:
            raise UnsupportedError(reason)
        import drjit

        drjit.set_thread_count(self.threads)
        start = time.perf_counter()
        try:
            self.loaded: Any = reference.load(scene_path, settings, self.variant)
        except SceneError as error:
            raise UnsupportedError(str(error)) from error
        self.scene_path = scene_path
        self.imported: Scene | None = None
        return {"load_seconds": time.perf_counter() - start}

    def render(
        self,
        seed: int,
        spp: int,
        *,
        engine: str = "depth_first",
        options: Mapping[str, object] = NO_OPTIONS,
        count_rays: bool = False,
    ) -> RenderResult:
        del engine, count_rays
        from reference import mitsuba as reference

        changes = {name: options[name] for name in self.knobs & options.keys()}
        loaded = reference.turn(self.loaded, **changes) if changes else self.loaded
        image, seconds = reference.render(loaded, seed, spp)
        return RenderResult(image=image, seconds=seconds)

    def _first_primitives(self, scene: Scene) -> NDArray[np.uint32]:
        """Number of each shape's first primitive, as the import counts them; uint32 [shapes]."""
        triangles = len(scene.triangles)
        return np.array(
            [
                triangles + shape.first
                if shape.kind == "sphere"
                else shape.first
                if own.is_mesh()
                else NONE
                for shape, own in zip(scene.shapes, self.loaded.scene.shapes(), strict=True)
            ],
            np.uint32,
        )

    def hold(self, rays: Rays) -> Held:
        """Hand rays to the variant."""
        import mitsuba as mi

        from harness.tracers.mitsuba_rays import hold

        mi.set_variant(self.variant)
        return hold(rays)

    def replay(self, rays: Held, way: Way, query: Query) -> RayHits:
        """Trace rays; there is one way, and nothing that it would count."""
        del way
        import mitsuba as mi

        from harness.tracers.mitsuba_rays import HeldRays, trace
        from reference.mitsuba.rendering import is_recentred

        if self.imported is None:
            recentre = is_recentred(self.scene_path)
            self.imported = load_scene(self.scene_path, recentre=recentre)
        first, dropped = self._first_primitives(self.imported), self.imported.dropped_triangles
        mi.set_variant(self.variant)
        assert isinstance(rays, HeldRays)
        return trace(self.loaded.scene, first, dropped, rays, query)


class MitsubaLlvm(_MitsubaTracer):
    """Vectorised CPU code, compiled by LLVM; Embree's traversal inside."""

    name: ClassVar[str] = "mitsuba-llvm"
    variant: ClassVar[str] = "llvm_ad_rgb"


class MitsubaCuda(_MitsubaTracer):
    """OptiX through Mitsuba."""

    name: ClassVar[str] = "mitsuba-cuda"
    on_gpu: ClassVar[bool] = True
    variant: ClassVar[str] = "cuda_ad_rgb"


class MitsubaScalar(_MitsubaTracer):
    """Plain C++, one ray at a time."""

    name: ClassVar[str] = "mitsuba-scalar"
    variant: ClassVar[str] = "scalar_rgb"
    warm_ups: ClassVar[int] = 1

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        """Make a scene ready, unless it uses what the project registers from Python."""
        state = parse_scene(
            scene_path,
            self.variant,
            width=settings.width,
            height=settings.height,
            integrator={"type": "path"},
        )
        used = {node.props.plugin_name() for node in state.nodes} & PYTHON_PLUGINS
        if used:
            names = ", ".join(sorted(used))
            raise UnsupportedError(
                f"the scene uses {names}, registered from Python, "
                "which Mitsuba's scalar variants cannot run"
            )
        return super().load(scene_path, settings)
