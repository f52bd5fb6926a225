"""Which of Mitsuba's plugins a scene may use, and which of them this benchmark replaces."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import mitsuba as mi

    SceneNode = mi.parser.SceneNode

Status = Literal["supported", "missing", "ignored"]

SUPPORTED: Mapping[str, tuple[str, ...]] = {
    "Shape": ("sphere", "rectangle", "cube", "disk", "ply", "obj"),
    "BSDF": ("phong", "diffuse", "conductor", "dielectric", "twosided"),
    "Emitter": ("area", "constant"),
    "Sensor": ("perspective",),
    "Film": ("hdrfilm",),
    "Texture": ("uniform", "srgb"),
}
"""Plugins that every tracer understands, by Mitsuba's type of object."""

REPLACED: Mapping[str, str] = {
    "Integrator": "the integrator of the lighting model, with the depths of settings.yaml",
    "Sampler": "independent samples, with the counts of the run's settings",
    "ReconstructionFilter": "a box filter",
}
"""What stands in for the plugins that would let tracers differ; any of them may be written."""

MEDIA = ("Medium", "PhaseFunction", "Volume")


def type_name(node: "SceneNode") -> str:
    """Mitsuba's type of object of a node: "Shape", "BSDF", "ReconstructionFilter", ..."""
    return str(node.type).rpartition(".")[2]


def plugin_status(node: "SceneNode") -> Status:
    """Whether the plugin of a node is supported, missing, or replaced by another."""
    kind = type_name(node)
    if kind in REPLACED:
        return "ignored"
    return "supported" if node.props.plugin_name() in SUPPORTED.get(kind, ()) else "missing"


def refusal(kind: str) -> str:
    """What is said of a missing plugin of a type of object."""
    if kind in MEDIA:
        return "participating media are not supported"
    if kind == "Unknown":
        return "there is no such plugin"
    if kind not in SUPPORTED:
        return f"objects of the type {kind.lower()} are not supported"
    noun = kind if kind.isupper() else kind.lower()
    return f"unsupported {noun}; supported {_are(SUPPORTED[kind])}"


def _are(names: tuple[str, ...]) -> str:
    return f"{'is' if len(names) == 1 else 'are'} {', '.join(names)}"
