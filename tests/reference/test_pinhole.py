"""The double-precision reference of eye rays, against brute force over all pairs."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from harness.eye_rays import corner_rays
from harness.scene import Scene, active_variant, load_scene
from reference.pinhole import NONE, closest_hits, film_boxes

SCENE = {
    "type": "scene",
    "sensor": {
        "type": "perspective",
        "fov": 50.0,
        "film": {"type": "hdrfilm", "width": 24, "height": 16},
    },
    "ball": {"type": "sphere", "center": [0.3, 0.1, 4.0], "radius": 1.0},
    # Beside the camera, and partly behind it.
    "near-ball": {"type": "sphere", "center": [0.55, 0.0, 0.1], "radius": 0.5},
    "cube": {"type": "cube"},
    "floor": {"type": "rectangle"},
    "light": {
        "type": "sphere",
        "center": [0.0, 3.0, 2.0],
        "radius": 0.2,
        "emitter": {"type": "area"},
    },
}


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Spheres and triangles before, around and behind a camera that looks along z."""
    import mitsuba as mi

    with active_variant("scalar_rgb"):
        transform = mi.ScalarTransform4f
    placed = {
        **SCENE,
        "cube": {
            **SCENE["cube"],
            "to_world": transform().translate([-1, 0, 5]).rotate([1, 1, 0], 35).scale(0.7),
        },
        # A floor that reaches behind the camera.
        "floor": {
            **SCENE["floor"],
            "to_world": transform().translate([0, -1, 0]).rotate([1, 0, 0], -90).scale(20),
        },
    }
    return load_scene(placed)


def brute_force(
    scene: Scene, origins: NDArray[np.float32], directions: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Every ray with every primitive, by other formulas: Cramer's rule, and the plain quadratic."""
    best, primitive = np.full(len(origins), np.inf), np.full(len(origins), NONE, np.uint32)
    corners = scene.vertices[scene.triangles].astype(np.float64)
    for i, (o, d) in enumerate(
        zip(origins.astype(np.float64), directions.astype(np.float64), strict=True)
    ):
        found = [(np.inf, NONE)]
        for k, (a, b, c) in enumerate(corners):
            matrix = np.stack([b - a, c - a, -d], axis=1)
            if abs(np.linalg.det(matrix)) > 0.0:
                u, v, t = np.linalg.solve(matrix, o - a)
                if min(u, v, 1 - u - v, t) >= 0.0:
                    found.append((t, k))
        for k, (x, y, z, radius) in enumerate(scene.spheres.astype(np.float64)):
            f = o - (x, y, z)
            roots = np.roots([d @ d, 2 * f @ d, f @ f - radius**2])
            real = [t.real for t in roots if abs(t.imag) == 0.0 and t.real > 0.0]
            found += [(min(real), len(corners) + k)] if real else []
        best[i], primitive[i] = min(found)
    return best, primitive


def test_the_reference_finds_what_all_pairs_find(scene: Scene):
    origins, directions = corner_rays(scene.camera)
    found = closest_hits(scene, origins, directions)
    t, primitive = brute_force(scene, origins, directions)
    assert len(set(primitive)) > 5, set(primitive)
    assert (found.primitive == primitive).all(), np.flatnonzero(found.primitive != primitive)
    hit = primitive != NONE
    assert np.isinf(found.t[~hit]).all() and hit.any() and not hit.all()
    # The plain quadratic cancels; both are some hundred roundings of double precision apart.
    np.testing.assert_allclose(found.t[hit], t[hit], rtol=1e-12)


def test_rays_of_another_camera_are_tested_in_the_wrong_places(scene: Scene):
    """Negative control: the boxes matter; a camera moved after the rays were made loses hits."""
    origins, directions = corner_rays(scene.camera)
    x, y, z = scene.camera.origin
    moved = replace(scene, camera=replace(scene.camera, origin=(x + 1.0, y, z)))
    whole, lost = (closest_hits(one, origins, directions) for one in (scene, moved))
    assert (whole.primitive != lost.primitive).any()
    assert (lost.t >= whole.t).all()


def test_boxes_hold_projections_and_know_what_lies_behind(scene: Scene):
    camera = scene.camera
    place = np.array([5.0, 9.0])
    direction = np.array(camera.corner) + place @ np.array([camera.dx, camera.dy])
    point = np.array(camera.origin) + 3.0 * direction
    behind = np.array(camera.origin) - 3.0 * direction
    boxes = film_boxes(camera, np.array([[point] * 3, [behind] * 3, [point, behind, point]]))
    assert boxes[0, 0] <= 5 <= boxes[0, 1] and boxes[0, 2] <= 9 <= boxes[0, 3], boxes[0]
    assert boxes[0, 1] - boxes[0, 0] <= 4, boxes[0]
    assert boxes[1, 1] < boxes[1, 0], boxes[1]
    assert boxes[2].tolist() == [0, camera.width, 0, camera.height], boxes[2]
