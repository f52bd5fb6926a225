"""BSDF nodes of the parser's state read as `Material`s."""

from typing import TYPE_CHECKING

from harness.scene.nodes import Problems, children_of_type, colour, location, number
from harness.scene.plugins import refusal
from harness.scene.records import Material
from harness.scene.variant import active_variant

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    SceneNode = mi.parser.SceneNode

PHONG_PARAMETERS = (
    "diffuse_reflectance",
    "specular_reflectance",
    "ambient_reflectance",
    "exponent",
    "reflection",
    "transmission",
    "int_ior",
)
WHITE = (1.0, 1.0, 1.0)
GREY = (0.5, 0.5, 0.5)
BLACK = (0.0, 0.0, 0.0)

# Mitsuba gives a shape without BSDF a grey one, or a black one if it emits.
DEFAULT_MATERIAL = Material("default", "phong", diffuse=GREY, ambient=GREY)
LIGHT_MATERIAL = Material("light", "phong")


def check_bsdf(state: "ParserState", node: "SceneNode", problems: Problems) -> None:
    """Record what is not supported in a BSDF, at any depth."""
    plugin = node.props.plugin_name()
    if plugin != "twosided":
        _read(node, problems)
        return
    inner = children_of_type(state, node, "BSDF")
    if len(inner) != 1:
        problems.add(node, f"twosided is supported around one BSDF, not {len(inner)}")
    for index in inner:
        held = state.nodes[index]
        material = _read(held, problems)
        if held.props.plugin_name() == "twosided":
            problems.add(held, "twosided inside twosided")
        elif material is not None and (
            material.kind == "dielectric" or material.transmission > 0.0
        ):
            problems.add(node, "twosided around a BSDF that transmits")


def read_material(state: "ParserState", index: int, fallback_name: str) -> Material:
    """The material of a BSDF node that `check_bsdf` found nothing wrong with."""
    node = state.nodes[index]
    twosided = node.props.plugin_name() == "twosided"
    inner = state.nodes[children_of_type(state, node, "BSDF")[0]] if twosided else node
    material = _read(inner, Problems(state))
    assert material is not None, f"{fallback_name} was not checked"
    name = node.props.id() or inner.props.id() or fallback_name
    # Two sides of what reflects nothing are none.
    twosided = twosided and (
        max(*material.diffuse, *material.specular) > 0.0 or material.reflection > 0.0
    )
    return Material(
        name=name,
        kind=material.kind,
        diffuse=material.diffuse,
        specular=material.specular,
        ambient=material.ambient,
        exponent=material.exponent,
        reflection=material.reflection,
        transmission=material.transmission,
        ior=material.ior,
        twosided=twosided,
        location=location(state, node),
    )


def _read(node: "SceneNode", problems: Problems) -> Material | None:
    """Material of a BSDF that is not `twosided`; None where it cannot be read."""
    plugin = node.props.plugin_name()
    if plugin == "phong":
        return _phong(node, problems)
    if plugin == "diffuse":
        reflectance = colour(problems, node, "reflectance", GREY)
        return Material("", "phong", diffuse=reflectance, ambient=reflectance)
    if plugin == "conductor":
        return _conductor(node, problems)
    if plugin == "dielectric":
        return _dielectric(node, problems)
    if plugin != "twosided":
        problems.add(node, refusal("BSDF"))
    return None


def _phong(node: "SceneNode", problems: Problems) -> Material:
    unknown = [key for key in node.props if key not in PHONG_PARAMETERS]
    for key in unknown:
        problems.add(node, f'unknown parameter "{key}" of phong')
    diffuse = colour(problems, node, "diffuse_reflectance", GREY)
    exponent = number(problems, node, "exponent", 30.0)
    if exponent <= 0.0:
        problems.add(node, f'"exponent" must be greater than 0, not {exponent:g}')
    constants = {}
    for name in ("reflection", "transmission"):
        constants[name] = number(problems, node, name, 0.0)
        if not 0.0 <= constants[name] <= 1.0:
            problems.add(node, f'"{name}" must be in [0, 1], not {constants[name]:g}')
    ior = number(problems, node, "int_ior", 1.5)
    if ior <= 0.0:
        problems.add(node, f'"int_ior" must be greater than 0, not {ior:g}')
    return Material(
        "",
        "phong",
        diffuse=diffuse,
        specular=colour(problems, node, "specular_reflectance", BLACK),
        ambient=colour(problems, node, "ambient_reflectance", diffuse),
        exponent=exponent,
        ior=ior,
        **constants,
    )


def _refuse_tint(node: "SceneNode", problems: Problems, name: str) -> None:
    if colour(problems, node, name, WHITE) != WHITE:
        problems.add(node, f'"{name}" must be 1')


def _conductor(node: "SceneNode", problems: Problems) -> Material:
    """Only Mitsuba's ideal mirror: material "none", which is eta = 0, k = 1."""
    _refuse_tint(node, problems, "specular_reflectance")
    material = str(node.props.get("material", "none"))
    eta = colour(problems, node, "eta", BLACK)
    k = colour(problems, node, "k", WHITE)
    if material != "none" or eta != BLACK or k != WHITE:
        problems.add(node, 'only the ideal mirror is supported: material "none", or eta 0 and k 1')
    return Material("", "phong", reflection=1.0)


def _dielectric(node: "SceneNode", problems: Problems) -> Material:
    """Smooth glass. Indices may be names of materials, which Mitsuba's own table knows."""
    import mitsuba as mi

    _refuse_tint(node, problems, "specular_reflectance")
    _refuse_tint(node, problems, "specular_transmittance")
    description = {"type": "dielectric"} | {
        key: node.props[key] for key in ("int_ior", "ext_ior") if key in node.props
    }
    ior = 1.5
    try:
        with active_variant("scalar_rgb"):
            ior = float(mi.traverse(mi.load_dict(description))["eta"])
    except RuntimeError as error:
        problems.add(node, str(error).rpartition("] ")[2].strip())
    else:
        if not 0.0 < ior < float("inf"):
            problems.add(node, f"the ratio of its indices must be positive and finite, not {ior}")
    return Material("", "dielectric", ior=ior)
