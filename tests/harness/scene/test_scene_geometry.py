"""Imported geometry against Mitsuba's own intersections."""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np
import pytest

from harness.scene import Scene, active_variant, load_scene, parse_scene, parser_config

FLIP = '<boolean name="flip_normals" value="true"/>'
TURN = '<rotate y="0.6" z="0.8" angle="{}"/><translate x="{}" y="{}"/>'

ZOO = "".join(
    f'<shape type="{plugin}" id="{name}">{extra}<transform name="to_world">{scale}'
    f"{TURN.format(20 * k + 10, 3 * (k % 4), 3 * (k // 4))}</transform></shape>"
    for k, (name, plugin, extra, scale) in enumerate(
        [
            ("sphere", "sphere", "", ""),
            ("flipped-sphere", "sphere", FLIP, '<scale value="0.7"/>'),
            ("mirrored-sphere", "sphere", "", '<scale x="-1"/>'),
            ("placed-sphere", "sphere", '<point name="center" x=".2" y=".1" z=".3"/>', ""),
            ("rectangle", "rectangle", "", '<scale x="0.5"/>'),
            ("flipped-rectangle", "rectangle", FLIP, ""),
            ("cube", "cube", "", '<scale x="0.5" y="0.8" z="0.3"/>'),
            ("flipped-cube", "cube", FLIP, ""),
            ("disk", "disk", "", ""),
            ("flipped-disk", "disk", FLIP, '<scale x="0.5"/>'),
            ("mirrored-disk", "disk", "", '<scale x="-1"/>'),
        ]
    )
)


def closest_hit(
    scene: Scene, origin: np.ndarray, along: np.ndarray
) -> tuple[float, int, np.ndarray] | None:
    """Distance, shape and geometric normal of the closest hit, by brute force in float64."""
    best: tuple[float, int, np.ndarray] | None = None
    corners = scene.vertices[scene.triangles].astype(np.float64)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.einsum("tx,tx->t", a - origin, normal) / (normal @ along)
        p = origin + t[:, None] * along
        inside = np.isfinite(t) & (t > 1e-6)
        for first, second in ((a, b), (b, c), (c, a)):
            inside &= np.einsum("tx,tx->t", np.cross(second - first, p - first), normal) >= 0.0
    if inside.any():
        k = int(np.argmin(np.where(inside, t, np.inf)))
        best = (float(t[k]), int(scene.triangle_shape[k]), normal[k] / np.linalg.norm(normal[k]))
    for sphere, owner in zip(scene.spheres.astype(np.float64), scene.sphere_shape, strict=True):
        centre, radius = sphere[:3], sphere[3]
        half = along @ (centre - origin)
        root = half * half - (centre - origin) @ (centre - origin) + radius * radius
        if root < 0.0:
            continue
        roots = [r for r in (half - math.sqrt(root), half + math.sqrt(root)) if r > 1e-6]
        if roots and (best is None or roots[0] < best[0]):
            outwards = (origin + roots[0] * along - centre) / radius
            sign = -1.0 if scene.shapes[int(owner)].flip_normals else 1.0
            best = (roots[0], int(owner), sign * outwards)
    return best


def test_hits_and_sides_agree_with_mitsuba_for_every_shape_and_flip(write_scene: Any) -> None:
    file = write_scene(ZOO)
    scene = load_scene(file)
    seen: dict[str, int] = {}
    generator = np.random.default_rng(3)
    state = parse_scene(file, "scalar_rgb", integrator={"type": "path"})
    with active_variant("scalar_rgb"):
        built = mi.parser.instantiate(parser_config("scalar_rgb"), state)
        for _ in range(700):
            target = [3.0, 3.0, 3.0] * generator.random(3) * [4, 3, 0.3] - [1, 1, 0.5]
            along = generator.normal(size=3)
            along /= np.linalg.norm(along)
            origin = np.array(target) - 4.0 * along
            theirs = built.ray_intersect(
                mi.ScalarRay3f(mi.ScalarPoint3f(origin), mi.ScalarVector3f(along))
            )
            ours = closest_hit(scene, origin, along)
            if not theirs.is_valid() or ours is None:
                # A polygon is not quite a disk: its rim may be missed by one of the two.
                assert theirs.is_valid() == (ours is not None) or "disk" in (
                    theirs.shape.id() if theirs.is_valid() else scene.shapes[ours[1]].name
                )
                continue
            name = theirs.shape.id()
            if name != scene.shapes[ours[1]].name:
                assert "disk" in name + scene.shapes[ours[1]].name
                continue
            message = (name, origin, along, theirs.t, ours)
            assert theirs.t == pytest.approx(ours[0], abs=2e-5), message
            # Grazing hits of a float32 sphere lose half the digits of the normal.
            assert np.abs(np.array(theirs.n) - ours[2]).max() < 2e-3, message
            seen[name] = seen.get(name, 0) + 1
    assert set(seen) == {shape.name for shape in scene.shapes}
    assert min(seen.values()) > 8, seen


def test_a_disk_becomes_a_polygon_of_the_same_area(write_scene: Any) -> None:
    scene = load_scene(
        write_scene(
            '<shape type="disk"><transform name="to_world"><scale value="2"/></transform></shape>'
        )
    )
    corners = scene.vertices[scene.triangles].astype(np.float64)
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert len(area) == 1024
    assert area.sum() == pytest.approx(4.0 * math.pi, rel=1e-6)


def ply(vertices: str, faces: str, normals: bool = False) -> str:
    extra = "".join(f"property float n{axis}\n" for axis in "xyz") if normals else ""
    return (
        f"ply\nformat ascii 1.0\nelement vertex {len(vertices.splitlines())}\n"
        f"property float x\nproperty float y\nproperty float z\n{extra}"
        f"element face {len(faces.splitlines())}\nproperty list uchar int vertex_indices\n"
        f"end_header\n{vertices}\n{faces}\n"
    )


MESH = '<shape type="ply" id="mesh"><string name="filename" value="mesh.ply"/>{}</shape>'


@pytest.mark.parametrize(
    ("normals", "extra", "smooth"),
    [
        ("0.1 0 1", "", True),
        ("0 0 1", "", False),
        ("0.1 0 1", '<boolean name="face_normals" value="true"/>', False),
    ],
)
def test_a_mesh_is_smooth_only_where_its_normals_leave_its_faces(
    write_scene: Any, normals: str, extra: str, smooth: bool
) -> None:
    file = write_scene(MESH.format(extra))
    vertices = f"0 0 0 {normals}\n1 0 0 0 0 1\n0 1 0 0 0 1"
    (file.parent / "mesh.ply").write_text(ply(vertices, "3 0 1 2", normals=True))
    scene = load_scene(file)
    assert scene.shapes[0].smooth is smooth
    assert scene.features.smooth_normals is smooth
    assert bool(np.abs(scene.normals).max() > 0.0) is smooth


def test_flipping_a_mesh_swaps_its_winding_and_negates_its_normals(write_scene: Any) -> None:
    file = write_scene(MESH.format("") + MESH.replace('"mesh"', '"flipped"', 1).format(FLIP))
    vertices = "0 0 0 .3 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1"
    (file.parent / "mesh.ply").write_text(ply(vertices, "3 0 1 2", normals=True))
    scene = load_scene(file)
    assert np.array_equal(scene.normals[3:], -scene.normals[:3])
    assert scene.triangles[1].tolist() == [3, 5, 4]


def test_arrays_have_the_documented_types(write_scene: Any) -> None:
    scene = load_scene(write_scene('<shape type="cube"/><shape type="sphere"/>'))
    for name, dtype, columns in (
        ("vertices", np.float32, 3),
        ("normals", np.float32, 3),
        ("triangles", np.uint32, 3),
        ("triangle_shape", np.uint32, None),
        ("spheres", np.float32, 4),
        ("sphere_shape", np.uint32, None),
    ):
        array = getattr(scene, name)
        assert array.dtype == dtype, name
        assert array.flags.c_contiguous, name
        assert array.ndim == 1 if columns is None else array.shape[1] == columns, name


def test_a_scene_without_triangles_has_empty_arrays(write_scene: Any) -> None:
    scene = load_scene(write_scene('<shape type="sphere"/>'))
    assert scene.vertices.shape == scene.triangles.shape == (0, 3)
    assert scene.triangle_shape.shape == (0,)
    assert scene.triangle_shape.dtype == np.uint32
