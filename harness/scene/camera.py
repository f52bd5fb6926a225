"""Mitsuba's `perspective` sensor as an affine map from film positions to directions, in float64."""

import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from harness.scene.nodes import Problems, children_of_type, number
from harness.scene.records import Camera, Vector

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState
    Properties = mi.Properties

# Diagonal of the 36 x 24 mm film that Mitsuba's focal lengths refer to.
FILM_DIAGONAL_MM = math.hypot(36.0, 24.0)


def tangent_half_width(props: "Properties", aspect: float) -> float:
    """Tangent of half the horizontal field of view, from `fov` and `fov_axis`, or `focal_length`.

    aspect: width over height of the whole film. The axes are those of Mitsuba's `perspective`; its
    plugin has refused bad values before.
    """
    if "fov" in props:
        tangent = math.tan(0.5 * math.radians(float(props["fov"])))
        axis = str(props.get("fov_axis", "x")).lower()
    else:
        focal_length = str(props.get("focal_length", "50mm")).removesuffix("mm")
        tangent = 0.5 * FILM_DIAGONAL_MM / float(focal_length)
        axis = "diagonal"
    if axis == "smaller":
        axis = "y" if aspect > 1.0 else "x"
    elif axis == "larger":
        axis = "x" if aspect > 1.0 else "y"
    if axis == "y":
        return tangent * aspect
    if axis == "diagonal":
        return tangent / math.sqrt(1.0 + 1.0 / (aspect * aspect))
    return tangent


def read_camera(state: "ParserState") -> Camera:
    """The camera of a state whose film `parse_scene` has fixed, with crop and principal point."""
    sensor = state.nodes[children_of_type(state, state.nodes[0], "Sensor")[0]]
    film = state.nodes[children_of_type(state, sensor, "Film")[0]].props
    props = sensor.props
    film_width, film_height = int(film["width"]), int(film["height"])
    aspect = film_width / film_height
    half_width = tangent_half_width(props, aspect)
    half_height = half_width / aspect
    problems = Problems(state)
    u = number(problems, sensor, "principal_point_offset_x", 0.0)
    v = number(problems, sensor, "principal_point_offset_y", 0.0)
    u += int(film["crop_offset_x"]) / film_width
    v += int(film["crop_offset_y"]) / film_height

    to_world = to_world_matrix(props)
    # The sensor's x axis points left in the picture: film positions run against it.
    axes = to_world[:3, :3] / np.linalg.norm(to_world[:3, :3], axis=0)
    corner = axes @ np.array([(1.0 - 2.0 * u) * half_width, (1.0 - 2.0 * v) * half_height, 1.0])
    return Camera(
        origin=_vector(to_world[:3, 3]),
        corner=_vector(corner),
        dx=_vector(axes[:, 0] * (-2.0 * half_width / film_width)),
        dy=_vector(axes[:, 1] * (-2.0 * half_height / film_height)),
        near=float(props.get("near_clip", 1e-2)),
        width=int(film["crop_width"]),
        height=int(film["crop_height"]),
    )


def to_world_matrix(props: "Properties") -> npt.NDArray[np.float64]:
    """The 4 x 4 `to_world` of a node in double precision, identity where it has none."""
    if "to_world" not in props:
        return np.eye(4)
    return np.array(props["to_world"].matrix, dtype=np.float64)


def _vector(values: npt.NDArray[np.float64]) -> Vector:
    return (float(values[0]), float(values[1]), float(values[2]))
