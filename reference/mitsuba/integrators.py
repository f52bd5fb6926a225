"""The integrators ``haste`` and ``whitted``: docs/lighting.md as plug-ins of Mitsuba.

They are truth, never a row in a comparison: they follow one child at random where the models trace
two. They do not run in scalar variants.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import mitsuba as mi

from reference.mitsuba.entities import Entities, read_entities
from reference.mitsuba.models import ModelSettings, trace
from reference.mitsuba.phong import read_colour

DEFAULT_AMBIENT = 0.1


def _positive(props: Any, name: str, default: int) -> int:
    value = int(props.get(name, default))
    if value < 1:
        raise ValueError(f"{props.plugin_name()}: {name} = {value} must be at least 1")
    return value


@cache
def integrator_classes(variant: str) -> dict[str, type]:
    """The classes by plug-in name, for ``variant``, which must be active at the first call."""
    if mi.variant() != variant:
        raise RuntimeError(f"integrators for {variant} asked for while {mi.variant()} is active")

    class LayeredIntegrator(mi.SamplingIntegrator):
        """Traces the paper's ray tree; the settings tell the two models apart."""

        settings: ModelSettings

        def __init__(self, props: Any) -> None:
            mi.SamplingIntegrator.__init__(self, props)
            self._prepared_for: int | None = None
            self._entities: Entities | None = None

        def prepare(self, scene: Any) -> None:
            """Reads the materials and lights of ``scene``; the first sample would do it, too."""
            # The address, not the object: a reference to the scene that owns this integrator would
            # keep both alive for ever.
            if self._prepared_for != scene.ptr:
                self._entities = read_entities(scene)
                self._prepared_for = scene.ptr

        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> tuple[Any, Any, list[Any]]:
            del medium
            self.prepare(scene)
            radiance, hit = trace(scene, self._entities, self.settings, sampler, ray, active)
            return radiance, hit, []

        def to_string(self) -> str:
            return f"{type(self).__name__}[{self.settings}]"

    class Haste(LayeredIntegrator):
        """Equations 1 to 7 and 9: many points a light, ambient rays."""

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            self.settings = ModelSettings(
                max_layers=_positive(props, "max_layers", 4),
                light_samples=_positive(props, "light_samples", 1),
                ambient_samples=_positive(props, "ambient_samples", 1),
                ambient=None,
            )

    class Whitted(LayeredIntegrator):
        """The same with one point a light, its centroid, and a constant ambient light."""

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            self.settings = ModelSettings(
                max_layers=_positive(props, "max_layers", 4),
                light_samples=0,
                ambient_samples=0,
                ambient=read_colour(props, "ambient", DEFAULT_AMBIENT),
            )

    return {"haste": Haste, "whitted": Whitted}
