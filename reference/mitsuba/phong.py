"""The ``phong`` BSDF: the paper's material as a physically based one, for Mitsuba's ``path``.

    f(wi, wo) = k_d i_d / pi + k_s i_s (alpha + 2) / (2 pi) max(0, R . wo)^alpha
                + mirror `reflection` + ideal refraction `transmission`

R is wi reflected about the shading normal. The specular lobe is normalised as by Lafortune and
Willems, "Using the modified Phong reflectance model for physically based rendering" (1994). The
diffuse and the specular lobe reflect on the front side; so does the mirror lobe, unless the
material transmits: then mirror and refraction act from both sides. ``twosided`` may wrap it if it
does not transmit. Parameters are those of docs/lighting.md; the same object carries the constants
that the integrators ``haste`` and ``whitted`` read.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cache, reduce
from operator import or_
from typing import Any

import drjit as dr
import mitsuba as mi

from reference.mitsuba.numeric import power_of_cosine, sample_power_of_cosine

# Attribute of the BSDF object that holds each parameter.
PARAMETERS = {
    "diffuse_reflectance": "diffuse",
    "specular_reflectance": "specular",
    "ambient_reflectance": "ambient",
    "exponent": "exponent",
    "reflection": "reflection",
    "transmission": "transmission",
    "int_ior": "int_ior",
}


class Lobe(IntEnum):
    """The four parts of the material, in the order of its components."""

    DIFFUSE = 0
    GLOSSY = 1
    MIRROR = 2
    REFRACTION = 3


def _label(props: Any) -> str:
    return f'{props.plugin_name()} "{props.id()}"'


def read_colour(props: Any, name: str, default: float | tuple[float, float, float]) -> Any:
    """Constant colour ``name`` of ``props``, as three floats.

    Raises
    ------
    ValueError
        If the parameter is a texture or a spectrum, or has a negative or non-finite channel.
    """
    value = props.get(name, default)
    types = mi.Properties.Type
    kind = props.type(name) if name in props else types.Color
    if kind == types.Spectrum and value.is_uniform():
        value = float(value.values()[0])
    elif kind not in (types.Color, types.Float, types.Integer):
        raise ValueError(f"{_label(props)}: {name} must be a constant colour")
    channels = (value,) * 3 if isinstance(value, (int, float)) else value
    colour = tuple(float(channel) for channel in channels)
    if not all(0.0 <= channel < float("inf") for channel in colour):
        raise ValueError(f"{_label(props)}: {name} = {colour} must be finite and >= 0")
    return colour


def _read_float(props: Any, name: str, default: float, *, positive: bool) -> float:
    value = float(props.get(name, default))
    if not 0.0 <= value < float("inf") or (positive and value == 0.0):
        bound = "> 0" if positive else ">= 0"
        raise ValueError(f"{_label(props)}: {name} = {value} must be finite and {bound}")
    return value


@cache
def phong_class(variant: str) -> type:
    """The BSDF class for ``variant``, which must be the active variant at the first call."""
    if mi.variant() != variant:
        raise RuntimeError(f"phong for {variant} asked for while {mi.variant()} is active")

    class Phong(mi.BSDF):
        """Phong material with ideal mirror and refraction lobes."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            diffuse = read_colour(props, "diffuse_reflectance", 0.5)
            specular = read_colour(props, "specular_reflectance", 0.0)
            ambient = read_colour(props, "ambient_reflectance", diffuse)
            reflection = _read_float(props, "reflection", 0.0, positive=False)
            transmission = _read_float(props, "transmission", 0.0, positive=False)
            strengths = (max(diffuse), max(specular), reflection, transmission)
            # A lobe that is absent leaves no code behind; the values of those present are data of
            # the kernel, so materials that have the same lobes share one compiled function.
            lobes = tuple(lobe for lobe in Lobe if strengths[lobe] > 0.0)
            self.lobes = lobes or (Lobe.DIFFUSE,)
            self.transmits = transmission > 0.0
            self.strengths = tuple(_data(mi.Float(strength)) for strength in strengths)
            self.diffuse = _data(mi.Color3f(diffuse))
            self.specular = _data(mi.Color3f(specular))
            self.ambient = _data(mi.Color3f(ambient))
            self.exponent = _data(mi.Float(_read_float(props, "exponent", 30.0, positive=True)))
            self.reflection = _data(mi.Float(reflection))
            self.transmission = _data(mi.Float(transmission))
            self.int_ior = _data(mi.Float(_read_float(props, "int_ior", 1.5, positive=True)))
            self.m_components = [_flags(lobe, self.transmits) for lobe in self.lobes]
            self.m_flags = reduce(or_, self.m_components)

        def traverse(self, callback: Any) -> None:
            for name, attribute in PARAMETERS.items():
                callback.put(name, getattr(self, attribute), mi.ParamFlags.NonDifferentiable)

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            return _sample(self, ctx, si, sample1, sample2, active)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return _evaluate(self, ctx, si.wi, wo, active)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return _evaluate(self, ctx, si.wi, wo, active)[1]

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return _evaluate(self, ctx, si.wi, wo, active)

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            return dr.select(active & (si.wi.z > 0.0), self.diffuse, 0.0)

        def to_string(self) -> str:
            values = (f"{name}={getattr(self, field)}" for name, field in PARAMETERS.items())
            return f"Phong[{', '.join(values)}]"

    return Phong


def _data(value: Any) -> Any:
    """``value`` as an input of the kernels that use it, instead of a literal in their code."""
    if dr.is_jit_v(value):
        dr.make_opaque(value)
    return value


def _kind(lobe: Lobe) -> Any:
    flags = mi.BSDFFlags
    return (
        flags.DiffuseReflection,
        flags.GlossyReflection,
        flags.DeltaReflection,
        flags.DeltaTransmission,
    )[lobe]


def _flags(lobe: Lobe, transmits: bool) -> int:
    flags = mi.BSDFFlags
    result = _kind(lobe) | flags.FrontSide
    if transmits and lobe in (Lobe.MIRROR, Lobe.REFRACTION):
        result |= flags.BackSide
    if lobe is Lobe.REFRACTION:
        result |= flags.NonSymmetric
    return int(result)


def _relative_index(bsdf: Any, wi: Any) -> Any:
    """Index on the far side over the index on the side of ``wi``."""
    return dr.select(wi.z >= 0.0, bsdf.int_ior, dr.rcp(bsdf.int_ior))


def _cosine_refracted_squared(wi: Any, eta: Any) -> Any:
    """Snell's law; negative under total internal reflection."""
    return 1.0 - (1.0 - dr.square(wi.z)) / dr.square(eta)


def _selection(bsdf: Any, ctx: Any, wi: Any) -> dict[Lobe, Any]:
    """Probability of each enabled lobe; all are 0 where nothing scatters."""
    front = wi.z > 0.0
    either = wi.z != 0.0
    refracts = either & (_cosine_refracted_squared(wi, _relative_index(bsdf, wi)) > 0.0)
    where = {
        Lobe.DIFFUSE: front,
        Lobe.GLOSSY: front,
        Lobe.MIRROR: either if bsdf.transmits else front,
        Lobe.REFRACTION: refracts,
    }
    weights = {}
    for index, lobe in enumerate(bsdf.lobes):
        if ctx.is_enabled(_kind(lobe), index):
            weights[lobe] = dr.select(where[lobe], bsdf.strengths[lobe], 0.0)
    total = sum(weights.values(), mi.Float(0.0))
    scale = dr.select(total > 0.0, dr.rcp(total), 0.0)
    return {lobe: weight * scale for lobe, weight in weights.items()}


def _evaluate(bsdf: Any, ctx: Any, wi: Any, wo: Any, active: Any) -> tuple[Any, Any]:
    """The BSDF times the cosine of ``wo``, and the density of ``wo``; without the delta lobes."""
    selection = _selection(bsdf, ctx, wi)
    active = active & (wi.z > 0.0) & (wo.z > 0.0)
    value, density = mi.Color3f(0.0), mi.Float(0.0)
    if Lobe.DIFFUSE in selection:
        cosine_density = wo.z * dr.inv_pi
        value += bsdf.diffuse * cosine_density
        density += selection[Lobe.DIFFUSE] * cosine_density
    if Lobe.GLOSSY in selection:
        lobe = dr.inv_two_pi * power_of_cosine(mi.reflect(wi), wo, bsdf.exponent)
        value += bsdf.specular * ((bsdf.exponent + 2.0) * lobe * wo.z)
        density += selection[Lobe.GLOSSY] * (bsdf.exponent + 1.0) * lobe
    return dr.select(active, value, 0.0), dr.select(active, density, 0.0)


def _sample(
    bsdf: Any, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any
) -> tuple[Any, Any]:
    """One lobe at random; the smooth ones share one density (balance heuristic)."""
    wi = si.wi
    selection = _selection(bsdf, ctx, wi)
    eta = _relative_index(bsdf, wi)
    record = dr.zeros(mi.BSDFSample3f, dr.width(wi))
    record.eta = 1.0
    weight = mi.Color3f(0.0)
    smooth = mi.Mask(False)
    open_ = mi.Mask(active)
    cumulative = mi.Float(0.0)
    for lobe, probability in selection.items():
        cumulative += probability
        chosen = open_ & (probability > 0.0) & (sample1 <= cumulative)
        open_ &= ~chosen
        index = bsdf.lobes.index(lobe)
        record.sampled_component[chosen] = mi.UInt32(index)
        record.sampled_type[chosen] = mi.UInt32(int(_kind(lobe)))
        record.wo[chosen] = _direction(bsdf, lobe, wi, eta, sample2)
        if lobe in (Lobe.DIFFUSE, Lobe.GLOSSY):
            smooth |= chosen
            continue
        record.pdf[chosen] = probability
        weight[chosen] = mi.Color3f(bsdf.strengths[lobe] / probability)
        if lobe is Lobe.REFRACTION:
            record.eta[chosen] = eta
            if ctx.mode == mi.TransportMode.Radiance:
                # Radiance over the square of the index is what refraction conserves.
                weight[chosen] /= dr.square(eta)
    value, density = _evaluate(bsdf, ctx, wi, record.wo, smooth)
    record.pdf[smooth] = density
    weight[smooth] = dr.select(density > 0.0, value / density, 0.0)
    return record, dr.select(active, weight, 0.0)


def _direction(bsdf: Any, lobe: Lobe, wi: Any, eta: Any, sample: Any) -> Any:
    if lobe is Lobe.DIFFUSE:
        return mi.warp.square_to_cosine_hemisphere(sample)
    mirrored = mi.reflect(wi)
    if lobe is Lobe.GLOSSY:
        return mi.Frame3f(mirrored).to_world(sample_power_of_cosine(sample, bsdf.exponent))
    if lobe is Lobe.MIRROR:
        return mirrored
    cosine = dr.safe_sqrt(_cosine_refracted_squared(wi, eta))
    return mi.Vector3f(-wi.x / eta, -wi.y / eta, dr.mulsign(-cosine, wi.z))
