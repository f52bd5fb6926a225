"""Rays that leave a surface: do they hit it again, or pass what lies close above it?

Both are asked of images, so of every tracer and of whatever it does to start a ray. A tilted mirror
under a white sky is white, but for the rays that hit the mirror again. A floor under an opaque lid
is black however close the lid is; what is not is a leak.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.measure.config import Config
from harness.measure.crew import Crew
from harness.measure.eye_rays import unshaded_settings
from harness.measure.files import hash_files, key_of, read_json, write_json
from harness.measure.messages import Render
from harness.measure.progress import Progress
from harness.measure.provenance import provenance, tracer_code
from harness.scene import load_scene, load_settings
from harness.statistics.metrics import luminance
from harness.tracers.registry import TRACERS, load_tracer
from harness.whole_files import write_whole

Image = NDArray[np.float64]

WHITE = 2.0**-10
"""How far from 1 a white sample may be."""
GRAZING = 80.0
"""Angle between the eye and the mirror's normal, degrees: most rays that hit it again are flat."""
SIZE = 64
"""Width and height of the images, in pixels."""
TILT = (20.0, 35.0, 50.0)
"""Rotations of the mirror about x, y and z, degrees: its coordinates are no round numbers."""

SETTINGS = """title: A surface
models: [path]
max_depth: 2
resolution: [64, 64]
recentre: false
"""

SENSOR = """    <sensor type="perspective">
        <float name="fov" value="{fov:.9g}"/>
        <float name="near_clip" value="{near:.9g}"/>
        <float name="far_clip" value="{far:.9g}"/>
        <transform name="to_world">
            <lookat origin="{origin}" target="{target}" up="0, 0, 1"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="64"/>
            <integer name="height" value="64"/>
            <rfilter type="box"/>
        </film>
    </sensor>
"""

MIRROR = """    <shape type="rectangle">
        <transform name="to_world">
            <rotate x="1" angle="{x:.9g}"/>
            <rotate y="1" angle="{y:.9g}"/>
            <rotate z="1" angle="{z:.9g}"/>
            <scale value="{scale:.9g}"/>
        </transform>
        <bsdf type="conductor"><string name="material" value="none"/></bsdf>
    </shape>
    <emitter type="constant"><rgb name="radiance" value="1, 1, 1"/></emitter>
"""

LID = """    <shape type="rectangle">
        <transform name="to_world"><scale value="{scale:.9g}"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.5, 0.5"/></bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="to_world">
            <translate z="{gap:.9g}"/>
            <scale value="{scale:.9g}"/>
        </transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0, 0, 0"/></bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="to_world">
            <rotate x="1" angle="180"/>
            <translate z="3"/>
            <scale value="{scale:.9g}"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="10, 10, 10"/></emitter>
    </shape>
"""


@dataclass(frozen=True, slots=True)
class Question:
    """One scene: what is asked of it, and what is swept."""

    quantity: str
    case: Mapping[str, float]
    body: str


def _text(scene: str, scale: float, origin: Any, target: Any, fov: float, reach: float) -> str:
    place = [", ".join(f"{scale * value:.9g}" for value in point) for point in (origin, target)]
    sensor = SENSOR.format(
        fov=fov, near=1e-6 * scale, far=scale * reach, origin=place[0], target=place[1]
    )
    return f'<scene version="3.0.0">\n    <integrator type="path"/>\n{sensor}{scene}</scene>\n'


def tilted_mirror(scale: float, eye: float) -> str:
    """A mirror of half-width `scale`, seen from `eye` half-widths away; it fills the image."""
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(TILT)):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[one, one] = step[other, other] = np.cos(angle)
        step[other, one], step[one, other] = np.sin(angle), -np.sin(angle)
        turn = step @ turn
    slant = math.radians(GRAZING)
    away = turn @ np.array([math.sin(slant), 0.0, math.cos(slant)])
    fov = 2.0 * math.degrees(math.atan(0.5 * math.cos(slant) / (eye + 1.0)))
    scene = MIRROR.format(x=TILT[0], y=TILT[1], z=TILT[2], scale=scale)
    return _text(scene, scale, (eye + 1.0) * away, (0.0, 0.0, 0.0), fov, 2.0 * eye + 10.0)


def floor_under_lid(scale: float, gap: float) -> str:
    """A floor and a lid of half-width `scale`, `gap` half-widths apart, seen from in between."""
    scene = LID.format(scale=scale, gap=gap)
    origin, target = (-0.5, 0.0, 0.5 * gap), (-0.5 + gap, 0.0, 0.0)
    return _text(scene, scale, origin, target, 30.0, 10.0)


def questions(plan: Mapping[str, Any]) -> list[Question]:
    """The scenes of a run, from its section `stability.surfaces`."""
    mirrors = [
        Question("self_hits_ppm", {"scale": scale, "eye": eye}, tilted_mirror(scale, eye))
        for scale in plan["scales"]
        for eye in plan["eyes"]
    ]
    lids = [
        Question("leaks_ppm", {"scale": scale, "gap": gap}, floor_under_lid(scale, gap))
        for scale in plan["scales"]
        for gap in plan["gaps"]
    ]
    return mirrors + lids


def measure_surfaces(config: Config, threads: int) -> Path:
    """Render every scene with every tracer, and count.

    Returns
    -------
    Path
        The record: a row for each tracer and scene.
    """
    path = config.surfaces_file
    plan = config["stability"]["surfaces"]
    who = {tracer: tracer_code(tracer) for tracer in config["tracers"]}
    key = key_of({"who": who, "plan": plan, "code": hash_files([Path(__file__)])})
    known = read_json(path)
    if isinstance(known, dict) and known.get("key") == key:
        return path
    progress = Progress("surfaces")
    folder, asked = path.parent / "surfaces", questions(plan)
    write_whole(folder / "settings.yaml", SETTINGS)
    rows: list[dict[str, Any]] = []
    with Crew(config["tracers"], threads, config["timeout_seconds"]) as crew:
        able = crew.probe(config["tracers"], "path")
        for tracer in config["tracers"]:
            for number, question in enumerate(asked):
                rows.append(
                    {
                        "tracer": tracer,
                        "precision": load_tracer(TRACERS[tracer]).precision,
                        "quantity": question.quantity,
                        "case": dict(question.case),
                        **_ask(crew, tracer, folder, number, question, plan["images"], able),
                    }
                )
            progress.say(f"{tracer}: {len(asked)} scenes")
    about = provenance(config, load_scene(folder / "scene-0.xml"), threads)
    write_json(path, {"key": key, "rows": rows, "provenance": about})
    return path


def _ask(
    crew: Crew,
    tracer: str,
    folder: Path,
    number: int,
    question: Question,
    images: int,
    able: Mapping[str, object],
) -> dict[str, Any]:
    """What one tracer makes of one scene: the share, or why there is none."""
    scene = folder / f"scene-{number}.xml"
    write_whole(scene, question.body)
    render = unshaded_settings(load_settings(scene), SIZE, SIZE)
    found: list[Image] = []
    takes_part = tracer in able and crew.takes_part(tracer, "path")
    if takes_part and crew.load(tracer, scene, render) is not None:
        for seed in range(images):
            result = crew.render(tracer, "path", Render(seed=seed, spp=1))
            if result is not None:
                found.append(luminance(result.image))
    if len(found) < images:
        row = next(row for row in reversed(crew.rows) if row["tracer"] == tracer)
        return {"status": row["status"], "reason": row["reason"]}
    wrong = {
        "leaks_ppm": lambda image: image > 0.0,
        "self_hits_ppm": lambda image: np.abs(image - 1.0) > WHITE,
    }[question.quantity]
    count = sum(int(wrong(image).sum()) for image in found)
    return {"status": "ok", "reason": "", "count": count, "of": images * SIZE * SIZE}
