"""A mesh at some size as a Mitsuba scene of its own, which every tracer can load."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harness.scene import Scene, SceneError
from harness.stability.rings import Triangles, Vertices
from harness.whole_files import write_whole

SCENE = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="near_clip" value="{near:.9g}"/>
        <float name="far_clip" value="{far:.9g}"/>
        <film type="hdrfilm">
            <integer name="width" value="1"/>
            <integer name="height" value="1"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="ply">
        <string name="filename" value="mesh.ply"/>
        <boolean name="face_normals" value="true"/>
        <bsdf type="diffuse"/>
    </shape>
    <emitter type="constant"/>
</scene>
"""

SETTINGS = """title: A mesh
models: [path]
max_depth: 1
resolution: [1, 1]
recentre: false
"""

FACE = np.dtype([("count", "u1"), ("corners", "<u4", 3)])


def scaled(vertices: Vertices, scale: float) -> Vertices:
    """Vertices times `scale`, rounded once."""
    return (vertices.astype(np.float64) * scale).astype(np.float32)


def largest_mesh(scene: Scene) -> tuple[Vertices, Triangles]:
    """Take the mesh of most triangles out of a scene.

    Raises
    ------
    SceneError
        The scene has no mesh.
    """
    meshes = [shape for shape in scene.shapes if shape.kind == "mesh"]
    if not meshes:
        raise SceneError(scene.path, ["it has no mesh whose stability could be tested"])
    mesh = max(meshes, key=lambda shape: shape.count)
    own = scene.triangles[mesh.first : mesh.first + mesh.count]
    used, index = np.unique(own, return_inverse=True)
    return scene.vertices[used], index.reshape(-1, 3).astype(np.uint32)


def write_mesh_scene(folder: Path, vertices: Vertices, triangles: Triangles) -> Path:
    """Write scene, settings and mesh to a folder, which is returned."""
    write_whole(folder / "mesh.ply", _ply(vertices, triangles))
    write_whole(folder / "settings.yaml", SETTINGS)
    reach = float(np.abs(vertices).max())
    scene = SCENE.format(near=1e-3 * reach, far=1e1 * reach)
    write_whole(folder / "scene.xml", scene)
    return folder


def _ply(vertices: Vertices, triangles: NDArray[np.uint32]) -> bytes:
    header = [
        *("ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"),
        *(f"property float {axis}" for axis in "xyz"),
        *(f"element face {len(triangles)}", "property list uchar uint vertex_indices"),
        "end_header",
    ]
    faces = np.zeros(len(triangles), FACE)
    faces["count"], faces["corners"] = 3, triangles
    body = np.ascontiguousarray(vertices, "<f4").tobytes() + faces.tobytes()
    return "\n".join(header).encode() + b"\n" + body
