"""Rays that leave a surface: do they hit it again, or pass what lies close above it?

Both are asked of images, so of every tracer and of whatever it does to start a ray. A tilted mirror
under a white sky is white, but for the rays that hit the mirror again. A floor under an opaque lid
is black however close the lid is; what is not is a leak.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.measure.config import Config
from harness.measure.crew import Crew
from harness.measure.eye_rays import unshaded_settings
from harness.measure.files import find_record, hash_files, key_of, write_json
from harness.measure.messages import Render
from harness.measure.own_folder import own_folder
from harness.measure.progress import Progress
from harness.measure.provenance import provenance, tracer_code
from harness.scene import load_scene, load_settings
from harness.stability.modes import MODES
from harness.stability.seen_scene import scene_text
from harness.statistics.metrics import luminance
from harness.tracers.registry import TRACERS, load_tracer
from harness.whole_files import write_whole

HERE = Path(__file__).parent
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
    eye, aim = (", ".join(f"{scale * value:.9g}" for value in point) for point in (origin, target))
    view, clips = (eye, aim, "0, 0, 1"), (1e-6 * scale, scale * reach)
    return scene_text(scene, fov=fov, clips=clips, view=view, size=SIZE)


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
    folder = path.parent / "surfaces"
    with own_folder(folder, "surfaces", "surfaces") as progress:
        who = {tracer: tracer_code(tracer) for tracer in config["tracers"]}
        code = hash_files([HERE / "seen_scene.py", Path(__file__)])
        key = key_of({"who": who, "plan": config["stability"]["surfaces"], "code": code})
        if find_record(path, key) is None:
            rows = _rows(config, threads, folder, progress)
            about = provenance(config, load_scene(folder / "scene-0.xml"), threads)
            write_json(path, {"key": key, "rows": rows, "provenance": about})
    return path


def _rows(config: Config, threads: int, folder: Path, progress: Progress) -> list[dict[str, Any]]:
    plan = config["stability"]["surfaces"]
    asked = questions(plan)
    write_whole(folder / "settings.yaml", SETTINGS)
    rows: list[dict[str, Any]] = []
    with Crew.of(config, config["tracers"], threads) as crew:
        able = crew.probe(config["tracers"], "path")
        for tracer in config["tracers"]:
            for number, question in enumerate(asked):
                for precision, found in _ask(
                    crew, tracer, folder / f"scene-{number}.xml", question, plan["images"], able
                ).items():
                    rows.append(
                        {
                            "tracer": tracer,
                            "precision": precision,
                            "quantity": question.quantity,
                            "case": dict(question.case),
                            **found,
                        }
                    )
            progress.say(f"{tracer}: {len(asked)} scenes")
    return rows


def _ask(
    crew: Crew,
    tracer: str,
    scene: Path,
    question: Question,
    images: int,
    able: Mapping[str, object],
) -> dict[str, dict[str, Any]]:
    """What one tracer makes of one scene, by precision: the share, or why there is none."""
    write_whole(scene, question.body)
    render = unshaded_settings(load_settings(scene), SIZE, SIZE)
    ready = tracer in able and crew.load(tracer, scene, render) is not None
    found: dict[str, dict[str, Any]] = {}
    for precision in MODES.get(tracer, (load_tracer(TRACERS[tracer]).precision,)):
        options: dict[str, object] = {"precision": precision} if tracer in MODES else {}
        count = None
        if ready:
            requests = [Render(seed=seed, spp=1, options=options) for seed in range(images)]
            count = _count(crew, tracer, question.quantity, requests)
        if count is None:
            found[precision] = asdict(crew.absence(tracer))
            ready = False
            continue
        of = images * SIZE * SIZE
        found[precision] = {"status": "ok", "reason": "", "count": count, "of": of}
    return found


def _count(crew: Crew, tracer: str, quantity: str, requests: list[Render]) -> int | None:
    """Samples that are wrong in some images; None where the tracer fails."""
    count = 0
    for request in requests:
        result = crew.render(tracer, "path", request)
        if result is None:
            return None
        image = luminance(result.image)
        wrong = image > 0.0 if quantity == "leaks_ppm" else np.abs(image - 1.0) > WHITE
        count += int(wrong.sum())
    return count
