"""The one list of tracers. A new tracer is a module and a line here."""

from importlib import import_module

from harness.tracers.base import Tracer

TRACERS: dict[str, str] = {
    "haste-cuda": "harness.tracers.haste:HasteCuda",
    "haste-cpu": "harness.tracers.haste:HasteCpu",
    "embree": "harness.tracers.haste:Embree",
    "mitsuba-llvm": "harness.tracers.mitsuba:MitsubaLlvm",
    "mitsuba-cuda": "harness.tracers.mitsuba:MitsubaCuda",
    "mitsuba-scalar": "harness.tracers.mitsuba:MitsubaScalar",
}
"""Name to ``module:class``, in the order of every table and legend."""

COLOURS: dict[str, str] = {
    "haste-cuda": "#D55E00",
    "haste-cpu": "#E69F00",
    "embree": "#0072B2",
    "mitsuba-llvm": "#009E73",
    "mitsuba-cuda": "#56B4E9",
    "mitsuba-scalar": "#CC79A7",
}
"""One colour a tracer throughout: Okabe and Ito's set, told apart by colour-blind readers."""


def load_tracer(target: str) -> type[Tracer]:
    """Import a tracer's class from ``module:class``."""
    module, _, name = target.partition(":")
    return getattr(import_module(module), name)
