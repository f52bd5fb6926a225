"""Scenes that are pushed towards their extremes, one number at a time, and what they must show.

Each scene has one colour all over its image, known in closed form, so that an error is one of
arithmetic and hardly one of noise.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from harness.stability.rings import Triangles, Vertices
from harness.stability.seen_scene import scene_text

Point = tuple[float, float, float]

FLOOR = 0.5
"""Reflectance of the floor under the lamp."""
SKY = 0.7
"""Radiance that is not a sum of few powers of two."""
REFLECTION = 0.999
SLIVERS = 256
FOOTPRINT = 1e-6
"""Half-width of what the camera sees of the floor, in units of the scene."""
AWAY = (0.8, 0.5, math.sqrt(0.11))
"""Direction in which a scene is moved from the origin, of unit length."""
EXTENT = 2.0
"""Width of the floor: what a distance from the origin is counted in."""

SETTINGS = """title: A scene at its extremes
models: [path]
resolution: [{size}, {size}]
recentre: {recentre}
"""

RECTANGLE = """    <shape type="rectangle">
        <transform name="to_world">
            <rotate x="1" angle="{turn}"/>
            <scale value="{half:.17g}"/>
            <translate value="{place}"/>
        </transform>
{inside}    </shape>
"""

MESH = """    <shape type="ply">
        <string name="filename" value="{file}.ply"/>
        <boolean name="face_normals" value="true"/>
{inside}    </shape>
"""

EMITTER = """        <emitter type="area">
            <rgb name="radiance" value="{0:.9g}, {0:.9g}, {0:.9g}"/>
        </emitter>
"""
DIFFUSE = """        <bsdf type="diffuse"><rgb name="reflectance" value="{0}, {0}, {0}"/></bsdf>
"""
CONSTANT = """    <emitter type="constant"><rgb name="radiance" value="{0}, {0}, {0}"/></emitter>
"""


@dataclass(frozen=True, slots=True)
class Extreme:
    """One scene: its files, the settings that it is rendered with, and what it must show.

    expected is the radiance of every channel. unit is what an error is a share of: `expected`, or
    the radiance that could leak where nothing must be seen.
    """

    scene: str
    expected: float
    unit: float
    depth: int = 1
    recentre: bool = False
    size: int = 32
    spp: int = 1
    meshes: Mapping[str, tuple[Vertices, Triangles]] = field(default_factory=dict)

    @property
    def settings(self) -> str:
        """The text of settings.yaml."""
        return SETTINGS.format(size=self.size, recentre="true" if self.recentre else "false")


@dataclass(frozen=True, slots=True)
class Hazard:
    """Something that is pushed: the key of `case` that names it, and the scene of each value."""

    name: str
    key: str
    scene: str
    """name in the column `scene`"""
    title: str
    make: Callable[[float], Extreme]
    kinds: tuple[str, ...] = ()
    """what the numbers stand for, where they are none"""

    def case(self, value: float) -> dict[str, float | int | str]:
        """What stands in the column `case`."""
        if self.kinds:
            return {self.key: self.kinds[int(value)]}
        if self.key in ("samples", "max_depth"):
            return {self.key: int(value)}
        case: dict[str, float | int | str] = {self.key: float(value)}
        if self.name.startswith("distance"):
            case["recentred"] = "yes" if self.name.endswith("recentred") else "no"
        return case


def _point(values: "tuple[float, ...] | np.ndarray") -> str:
    return ", ".join(f"{float(value):.17g}" for value in values)


def _scene(
    body: str,
    eye: Point,
    target: Point,
    half: float,
    *,
    up: Point = (0.0, 0.0, 1.0),
    size: int = 32,
    reach: float = 0.0,
) -> str:
    """A scene seen from `eye`; the image is `half` on either side of `target`.

    What is not seen reaches `reach` far from the eye, for which the far plane has room.
    """
    distance = math.dist(eye, target)
    return scene_text(
        body,
        fov=2.0 * math.degrees(math.atan(half / distance)),
        clips=(1e-6 * distance, 1e3 * distance + reach),
        view=(_point(eye), _point(target), _point(up)),
        size=size,
    )


def lamp_over_floor(
    *,
    scale: float = 1.0,
    distance: float = 0.0,
    recentre: bool = False,
    eye: float = 2.0,
    elevation: float = 45.0,
    height: float = 1.0,
    half: float = 0.1,
    radiance: float = 1.0,
    spp: int = 1,
) -> Extreme:
    """A square lamp over the middle of a floor.

    The floor's radiance is reflectance times radiance times the configuration factor of the square,
    (4 / pi) s atan(s) with s = x / sqrt(1 + x^2) and x its half-width over its height (Howell, A
    Catalog of Radiation Heat Transfer Configuration Factors, B-4, four times).
    """
    middle = tuple(scale * distance * EXTENT * along for along in AWAY)

    def place(x: float, y: float, z: float) -> Point:
        return (middle[0] + scale * x, middle[1] + scale * y, middle[2] + scale * z)

    floor = RECTANGLE.format(
        turn=0, half=scale, place=_point(place(0, 0, 0)), inside=DIFFUSE.format(FLOOR)
    )
    lamp = RECTANGLE.format(
        turn=180,
        half=scale * half,
        place=_point(place(0, 0, height)),
        inside=DIFFUSE.format(0) + EMITTER.format(radiance),
    )
    slant, turn = math.radians(elevation), math.radians(20.0)
    across = eye * math.cos(slant)
    origin = place(across * math.cos(turn), across * math.sin(turn), eye * math.sin(slant))
    footprint = scale * FOOTPRINT * min(1.0, height)
    x = half / height
    s = x / math.sqrt(1.0 + x * x)
    expected = FLOOR * radiance * (4.0 / math.pi) * s * math.atan(s)
    return Extreme(
        _scene(
            floor + lamp,
            origin,
            place(0, 0, 0),
            footprint,
            reach=scale * (1e1 + 2.0 * height + 2.0 * half),
        ),
        expected,
        expected,
        depth=2,
        recentre=recentre,
        spp=spp,
    )


def _tilt() -> np.ndarray:
    """A rotation after which no coordinate is a round number, [3, 3]."""
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians((20.0, 35.0, 50.0))):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[one, one] = step[other, other] = np.cos(angle)
        step[other, one], step[one, other] = np.sin(angle), -np.sin(angle)
        turn = step @ turn
    return turn


def _along(direction: np.ndarray, length: float) -> Point:
    x, y, z = length * direction
    return (float(x), float(y), float(z))


def black_slivers(aspect: float) -> Extreme:
    """A black wall of slivers, whose length is 1 and `aspect` times their width; behind it the sky.

    Nothing is seen but what passes between them.
    """
    turn = _tilt()
    x = (np.arange(SLIVERS + 1) - 0.5 * SLIVERS) / aspect
    flat = np.zeros((2, SLIVERS + 1, 3))
    flat[..., 0] = x
    flat[0, :, 1], flat[1, :, 1] = -0.5, 0.5
    vertices = (flat.reshape(-1, 3) @ turn.T).astype(np.float32)
    low = np.arange(SLIVERS)
    high = low + SLIVERS + 1
    triangles = np.concatenate(
        [np.stack([low, low + 1, high + 1], -1), np.stack([low, high + 1, high], -1)]
    ).astype(np.uint32)
    body = MESH.format(file="slivers", inside=DIFFUSE.format(0)) + CONSTANT.format(1)
    half = min(0.25 * SLIVERS / aspect, 0.2)
    scene = _scene(body, _along(turn[:, 2], 1.0), (0, 0, 0), half, up=_along(turn[:, 1], 1.0))
    return Extreme(scene, 0.0, 1.0, meshes={"slivers": (vertices, triangles)})


KINDS = ("coincident", "duplicate", "zero_area", "needle")


def shining_wall(kind: float) -> Extreme:
    """A wall that shines, and triangles that nobody should see: 0 coincident, a second wall in the
    same place; 1 duplicate, every triangle twice; 2 zero_area, black ones before it with corners in
    one place or on one line; 3 needle, black ones whose width is the least number.
    """
    name = KINDS[int(kind)]
    turn = _tilt()
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float64) @ turn.T
    wall = corners.astype(np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    inside = DIFFUSE.format(0) + EMITTER.format(SKY)
    meshes = {"wall": (wall, np.concatenate([faces, faces]) if name == "duplicate" else faces)}
    body = MESH.format(file="wall", inside=inside)
    if name == "coincident":
        meshes["again"] = (wall, faces)
        body += MESH.format(file="again", inside=inside)
    elif name in ("zero_area", "needle"):
        random = np.random.default_rng(1)
        first, last = random.uniform(-0.3, 0.3, (2, 64, 3)) @ turn.T + 0.5 * turn[:, 2]
        middle = 0.5 * (first + last)
        if name == "needle":
            # Only beside the origin the least number is a width.
            first = np.zeros((64, 3))
            middle = np.full((64, 3), float(np.finfo(np.float32).smallest_subnormal))
        else:
            middle[::2] = first[::2]
        points = np.stack([first, middle, last], axis=1)
        vertices = points.reshape(-1, 3).astype(np.float32)
        meshes["none"] = (vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3))
        body += MESH.format(file="none", inside=DIFFUSE.format(0))
    scene = _scene(body, _along(turn[:, 2], 2.0), (0, 0, 0), 0.5, up=_along(turn[:, 1], 1.0))
    return Extreme(scene, SKY, SKY, meshes=meshes)


def glossy_plate(exponent: float) -> Extreme:
    """A glossy plate without loss, seen head-on under a sky: it shows half of the sky.

    The lobe (n + 2) / (2 pi) cos^n integrates to its reflectance there, at any exponent.
    """
    plate = RECTANGLE.format(
        turn=0,
        half=1.0,
        place="0, 0, 0",
        inside=f"""        <bsdf type="phong">
            <rgb name="diffuse_reflectance" value="0, 0, 0"/>
            <rgb name="specular_reflectance" value="0.5, 0.5, 0.5"/>
            <float name="exponent" value="{exponent:.9g}"/>
        </bsdf>
""",
    )
    scene = _scene(plate + CONSTANT.format(SKY), (0, 0, 3), (0, 0, 0), 1e-6, up=(0, 1, 0))
    return Extreme(scene, 0.5 * SKY, 0.5 * SKY, depth=2, spp=1024 if exponent < 100 else 16)


def room_of_mirrors(depth: float) -> Extreme:
    """A closed room of mirrors that all shine: a geometric series of so many terms."""
    body = (
        f"""    <shape type="cube">
        <boolean name="flip_normals" value="true"/>
        <bsdf type="phong">
            <rgb name="diffuse_reflectance" value="0, 0, 0"/>
            <float name="reflection" value="{REFLECTION}"/>
        </bsdf>
"""
        + EMITTER.format(1.0)
        + "    </shape>\n"
    )
    scene = _scene(body, (-0.4, -0.5, 0.1), (1.0, 0.6, -0.1), 1.2)
    expected = (1.0 - REFLECTION**depth) / (1.0 - REFLECTION)
    return Extreme(scene, expected, expected, depth=int(depth))


def one_pixel_of_sky(samples: float) -> Extreme:
    """A pixel of a sky, of so many samples; a ball behind the camera is never seen."""
    body = '    <shape type="sphere"><point name="center" x="0" y="0" z="9"/></shape>\n'
    scene = _scene(body + CONSTANT.format(SKY), (0, 0, 0), (0, 0, -1), 0.5, up=(0, 1, 0), size=1)
    return Extreme(scene, SKY, SKY, size=1, spp=int(samples))


LAMP = "lamp-over-floor"

HAZARDS: tuple[Hazard, ...] = (
    Hazard("scale", "scale", LAMP, "scale of the scene", lambda v: lamp_over_floor(scale=v)),
    Hazard(
        "distance",
        "distance",
        LAMP,
        "distance from the origin, in extents",
        lambda v: lamp_over_floor(distance=v),
    ),
    Hazard(
        "distance_recentred",
        "distance",
        LAMP,
        "the same, recentred",
        lambda v: lamp_over_floor(distance=v, recentre=True),
    ),
    Hazard("eye", "eye", LAMP, "distance of the eye", lambda v: lamp_over_floor(eye=v)),
    Hazard(
        "light_distance",
        "light_distance",
        LAMP,
        "distance of a lamp, seen as large",
        lambda v: lamp_over_floor(height=v, half=0.1 * v),
    ),
    Hazard(
        "light_size",
        "light_size",
        LAMP,
        "half-width of the lamp",
        lambda v: lamp_over_floor(
            half=v, eye=0.5, elevation=30.0, spp=512 if 0.1 < v < 1e3 else 16
        ),
    ),
    Hazard(
        "radiance", "radiance", LAMP, "radiance of the lamp", lambda v: lamp_over_floor(radiance=v)
    ),
    Hazard(
        "grazing",
        "elevation",
        LAMP,
        "angle between view and floor, degrees",
        lambda v: lamp_over_floor(elevation=v),
    ),
    Hazard("slivers", "aspect", "black-slivers", "length over width, triangles", black_slivers),
    Hazard(
        "triangles", "triangles", "shining-wall", "triangles that are none", shining_wall, KINDS
    ),
    Hazard("phong", "exponent", "glossy-plate", "exponent of a Phong lobe", glossy_plate),
    Hazard("depth", "max_depth", "room-of-mirrors", "length of paths", room_of_mirrors),
    Hazard("samples", "samples", "pixel-of-sky", "samples of a pixel", one_pixel_of_sky),
)
"""In the order of the report."""
