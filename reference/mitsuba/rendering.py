"""Loading and rendering scenes with Mitsuba: its native ``path`` and this package's integrators.

`load` and `render` leave their variant current: to and fro costs more than a small render.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.scene import (
    RenderSettings,
    SceneSource,
    active_variant,
    load_settings,
    mitsuba_errors,
    parse_scene,
    parser_config,
)
from reference.mitsuba.variants import UnavailableVariantError, available

SAMPLES_PER_PASS = 1 << 22
"""Most camera samples in flight at a time: what bounds the memory of the vectorised variants."""

SEEDS = 1 << 21
"""Seeds run below this; the bits above number the passes, so that no two passes share a stream."""

MAX_PASSES = 2**32 // SEEDS


@dataclass(frozen=True, slots=True)
class LoadedScene:
    """A scene built for one variant, with its integrator."""

    variant: str
    settings: RenderSettings
    scene: Any
    integrator: Any


@cache
def register(variant: str) -> None:
    """Makes the plug-ins ``phong``, ``haste`` and ``whitted`` known to ``variant``, once."""
    import mitsuba as mi

    with active_variant(variant):
        from reference.mitsuba.integrators import integrator_classes
        from reference.mitsuba.phong import phong_class

        mi.register_bsdf("phong", phong_class(variant))
        for name, integrator in integrator_classes(variant).items():
            mi.register_integrator(name, integrator)


def integrator_description(settings: RenderSettings) -> dict[str, Any]:
    """Mitsuba's description of the integrator for ``settings``."""
    import mitsuba as mi

    if settings.model == "path":
        return {"type": "path", "max_depth": settings.max_depth, "rr_depth": settings.rr_depth}
    if settings.model == "whitted":
        ambient = mi.ScalarColor3d(*settings.ambient)
        return {"type": "whitted", "max_layers": settings.max_layers, "ambient": ambient}
    if settings.model == "haste":
        return {
            "type": "haste",
            "max_layers": settings.max_layers,
            "light_samples": settings.light_samples,
            "ambient_samples": settings.ambient_samples,
        }
    raise ValueError(f'no Mitsuba integrator for the model "{settings.model}"')


def load(source: SceneSource, settings: RenderSettings, variant: str) -> LoadedScene:
    """Builds a scene (a folder ``scenes/<name>``, an XML file or a Mitsuba dictionary).

    Raises
    ------
    UnavailableVariantError
        If ``variant`` cannot run here, with the reason; or if a scalar variant is asked for one of
        the Python integrators.
    SceneError
        If the scene cannot be read, or not be rendered with the model.
    """
    reason = available(variant)
    if reason is not None:
        raise UnavailableVariantError(f"{variant}: {reason}")
    if variant.startswith("scalar") and settings.model != "path":
        raise UnavailableVariantError(
            f"{variant}: the integrator {settings.model} is vectorised Python code, "
            "which scalar variants do not run"
        )
    import mitsuba as mi

    register(variant)
    mi.set_variant(variant)
    name = "dictionary scene" if isinstance(source, Mapping) else str(source)
    state = parse_scene(
        source,
        variant,
        width=settings.width,
        height=settings.height,
        integrator=integrator_description(settings),
        recentre=is_recentred(source),
    )
    with mitsuba_errors(name):
        scene = mi.parser.instantiate(parser_config(variant), state)
        integrator = scene.integrator()
        if settings.model != "path":
            integrator.prepare(scene)
    return LoadedScene(variant=variant, settings=settings, scene=scene, integrator=integrator)


def turn(loaded: LoadedScene, **changes: int) -> LoadedScene:
    """The same scene with an integrator of other settings (``max_depth``, ``rr_depth``)."""
    import mitsuba as mi

    mi.set_variant(loaded.variant)
    settings = replace(loaded.settings, **changes)
    integrator = mi.load_dict(integrator_description(settings))
    return replace(loaded, settings=settings, integrator=integrator)


def is_recentred(source: SceneSource) -> bool:
    """Whether the settings of a scene's folder ask for it to be moved to the origin."""
    if isinstance(source, Mapping) or not Path(source).is_dir():
        return False
    return load_settings(source).recentre


def pass_sizes(spp: int, pixels: int) -> list[int]:
    """Samples a pixel of each pass: equal but for the first ones, which may have one more."""
    passes = -(-spp // max(1, SAMPLES_PER_PASS // pixels))
    if passes > MAX_PASSES:
        raise ValueError(f"{spp} spp of {pixels} pixels take {passes} passes, over {MAX_PASSES}")
    return [spp // passes + (k < spp % passes) for k in range(passes)]


def render(loaded: LoadedScene, seed: int, spp: int) -> tuple[NDArray[np.float64], float]:
    """Mean over ``spp`` samples a pixel.

    Returns
    -------
    The image, float64 [height, width, 3], linear sRGB, and the seconds that rendering took, kernel
    compilation included where a kernel is not cached (the first two renders of a loaded scene).

    Raises
    ------
    ValueError
        If ``seed`` is not in [0, 2^21), or ``spp`` < 1, or the samples need over 2^11 passes.
    """
    if not 0 <= seed < SEEDS:
        raise ValueError(f"seed {seed} is not in [0, {SEEDS})")
    if spp < 1:
        raise ValueError(f"spp = {spp} must be at least 1")
    import drjit as dr
    import mitsuba as mi

    settings = loaded.settings
    image = np.zeros((settings.height, settings.width, 3))
    seconds = 0.0
    mi.set_variant(loaded.variant)
    for index, samples in enumerate(pass_sizes(spp, settings.width * settings.height)):
        start = time.perf_counter()
        film = loaded.integrator.render(
            loaded.scene, seed=seed + index * SEEDS, spp=samples, develop=True, evaluate=True
        )
        dr.eval(film)
        dr.sync_thread()
        seconds += time.perf_counter() - start
        image += samples * np.asarray(film, dtype=np.float64)
    return image / spp, seconds
