"""How the GPU finds hits where nobody says how."""

from __future__ import annotations

import numpy as np
import pytest
from core_meshes import mesh_scene

from haste_cuda import _core

PRIVATE_STACKS = ("depth_first", "persistent")
QUEUES = ("packets", "streams", "layers", "wavefront")
SPHERE = [(0.0, 0.0, 0.0, 1.0)]


def strip(triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """That many triangles side by side."""
    i = np.arange(triangles + 2)
    vertices = np.stack([i, i % 2, np.zeros_like(i)], -1).astype(np.float32)
    return vertices, np.stack([i[:-2], i[1:-1], i[2:]], -1).astype(np.uint32)


@pytest.mark.parametrize("engine", PRIVATE_STACKS + QUEUES)
@pytest.mark.parametrize(
    ("primitives", "private_stacks", "queues"),
    [
        (1, "brute_force", "brute_force"),
        (8, "brute_force", "brute_force"),
        (9, "bvh2", "bvh8"),
        (65535, "bvh2", "bvh8"),
        (65536, "bvh8", "bvh8"),
    ],
)
def test_a_scene_has_the_hierarchy_that_its_primitives_are_worth(
    engine: str, primitives: int, private_stacks: str, queues: str
):
    """Spheres and triangles count alike."""
    scene = mesh_scene(*strip(primitives - 1), SPHERE)
    expected = private_stacks if engine in PRIVATE_STACKS else queues
    assert _core.image_traversal(scene, engine) == expected, f"{primitives} primitives"
