"""Moving a scene to the origin before its coordinates are rounded to single precision."""

from typing import TYPE_CHECKING

import numpy as np

from harness.scene.camera import to_world_matrix
from harness.scene.geometry import build_geometry
from harness.scene.nodes import Problems, children_of_type

if TYPE_CHECKING:
    import mitsuba as mi

    ParserState = mi.parser.ParserState


def recentre_state(state: "ParserState", problems: Problems) -> None:
    """Translate all shapes and the sensor by minus the centre of the scene's bounding box, in
    double.

    The edit is to the `to_world` of each node, so that a large translation in the file cancels
    before Mitsuba rounds it. Coordinates within a mesh file are as its writer rounded them.
    """
    import mitsuba as mi

    geometry = build_geometry(state, problems)
    if problems.lines:
        return
    corners = [geometry.vertices.astype(np.float64)]
    centres, radii = geometry.spheres[:, :3].astype(np.float64), geometry.spheres[:, 3:]
    corners += [centres - radii, centres + radii]
    points = np.concatenate(corners)
    offset = -0.5 * (points.min(axis=0) + points.max(axis=0))
    root = state.nodes[0]
    for index in children_of_type(state, root, "Shape") + children_of_type(state, root, "Sensor"):
        props = state.nodes[index].props
        matrix = to_world_matrix(props)
        matrix[:3, 3] += offset
        props["to_world"] = mi.ScalarTransform4d(matrix)
