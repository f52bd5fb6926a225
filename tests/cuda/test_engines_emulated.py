"""Every engine on an emulated GPU: the host's half and the kernels' logic, where there is no GPU.

A library plays NVRTC and has g++ compile the kernels, another one plays the driver and runs their
threads one after another. Resident warps, which work together, are left to a GPU.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from stubs import run_python

EMULATION = Path(__file__).parent / "emulation"
COMPILER = """
from pathlib import Path
import haste_cuda
from haste_cuda import nvrtc
nvrtc.wheel_folders = lambda major: [Path({folder!r})]
nvrtc.toolkit_folders = lambda major: []
"""
PROGRAM = """
import ctypes, json
from dataclasses import replace
from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

live = ctypes.CDLL("libcuda.so.1").emulated_live
live.restype = ctypes.c_long
folder = Path({scenes!r}) / {name!r}
own = load_settings(folder).render({model!r}, 12, 12)
settings = to_core_settings(replace(own, light_samples=2, ambient_samples=3))
scene = to_core(load_scene(folder, width=12, height=12), 2)
sampling = dict(seed=5, samples=6, count_rays={counted})
rays = ("camera", "shadow", "ambient", "bounce") if {counted} else ()
found = []
for schedule in json.loads({schedules!r}):
    lives = []
    for _ in range(2):
        answer = haste_cuda.render_cuda(
            scene, {model!r}, settings, traversal={traversal!r}, **sampling, **schedule
        )
        lives.append(live())
    counts = [answer[kind] for kind in rays]
    found.append((answer["film_sha256"], counts, answer["peak_queue_bytes"], lives))
answer = haste_cuda.render_cpu(scene, {model!r}, settings, **sampling)
counts = [answer[kind] for kind in rays]
print(json.dumps([(answer["film_sha256"], counts, answer["peak_queue_bytes"], (0, 0)), *found]))
"""

Schedule = dict[str, Any]

SCHEDULES: list[Schedule] = [
    {"engine": "depth_first"},
    {"engine": "persistent"},
    *(
        {"engine": "packets", "packet": packet, "order": order, "allocation": allocation, **limit}
        for packet, limit in ((64, {"queue_bytes": 1 << 15}), (512, {}), (1 << 17, {}))
        for order in ("fifo", "lifo")
        for allocation in ("per_packet", "once")
    ),
    *(
        {"engine": "streams", "packet": packet, "order": order, "streams": streams}
        for packet in (64, 1 << 15)
        for order in ("fifo", "lifo")
        for streams in (1, 3)
    ),
    *({"engine": "layers", "packet": packet} for packet in (64, 4096)),
    *(
        {"engine": "wavefront", "packet": packet, "streams": streams, **limit}
        for packet, limit in ((64, {}), (512, {"queue_bytes": 1 << 18}), (4096, {}))
        for streams in (1, 3)
    ),
]
"""Small packets and large ones, roomy queues and short ones, arrays below and above 2 MiB."""


# A floor of little more or little less light than a pass of 4,096 samples may bring: what the
# lamp adds by itself to every sample's ambient term decides.
BRIM = """
import numpy as np
for diffuse in (0.0, 0.9):
    settings = haste_cuda.Settings(max_layers=1, ambient=(1, 1, 1))
    square = np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], np.float32)
    lamp = np.array([[-1, -1, 8], [1, -1, 8], [0, 1, 8]], np.float32)
    scene = haste_cuda.Scene(
        vertices=np.concatenate([square, lamp]),
        normals=np.zeros((7, 3), np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]], np.uint32),
        triangle_shape=np.array([0, 0, 1], np.uint32),
        spheres=np.zeros((0, 4), np.float32),
        sphere_shape=np.zeros(0, np.uint32),
        shapes=[
            haste_cuda.Shape(kind="mesh", material=0, first=0, count=2),
            haste_cuda.Shape(kind="mesh", material=1, light=0, first=2, count=1),
        ],
        materials=[
            haste_cuda.Material(ambient=(2047.9,) * 3, diffuse=(diffuse,) * 3),
            haste_cuda.Material(),
        ],
        lights=[(1, (1.0, 1.0, 1.0))],
        camera=haste_cuda.Camera(
            origin=(0, 0, 5), corner=(-1, 1, -1), dx=(1, 0, 0), dy=(0, -1, 0), near=0.01,
            width=2, height=2,
        ),
    )
    for engine in {engines!r}:
        try:
            answer = haste_cuda.render_cuda(
                scene, "whitted", settings, seed=1, samples=4096, engine=engine
            )
        except haste_cuda.FilmOverflow as refusal:
            print(diffuse, engine, refusal)
        else:
            print(diffuse, engine, "fits")
"""
ENGINES = ("depth_first", "persistent", "packets", "streams", "layers", "wavefront")


@pytest.fixture(scope="module")
def emulation(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of libraries that play CUDA."""
    folder = tmp_path_factory.mktemp("emulation")
    for source, library in (("driver.cpp", "libcuda.so.1"), ("nvrtc.cpp", "libnvrtc.so.13")):
        command = ["g++", "-std=c++20", "-O1", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror"]
        command += ["-o", str(folder / library), str(EMULATION / source), "-ldl"]
        subprocess.run(command, check=True)
    return folder


Render = Callable[..., tuple["Left", list["Left"]]]


class Left(NamedTuple):
    """What a render has left."""

    film: str
    counts: list[int]
    """camera, shadow, ambient and bounce rays, where they were counted"""
    peak: float
    """most bytes in the queue"""
    lives: tuple[int, int]
    """things of the driver's after a first and a second render"""


@pytest.fixture
def run(
    emulation: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[str], list[str]]:
    """Lines that Python prints on a machine with the emulated GPU."""
    monkeypatch.setenv("HASTE_CACHE", str(tmp_path))
    monkeypatch.setenv("EMULATION_FOLDER", str(tmp_path))
    monkeypatch.setenv("EMULATION_HEADER", str(EMULATION / "emulated_cuda.h"))
    compiler = COMPILER.format(folder=str(emulation))
    return lambda program: run_python(compiler + program, emulation).splitlines()


@pytest.fixture
def render(run: Callable[[str], list[str]]) -> Render:
    """What the processor leaves of a scene in a model, and what each schedule does."""

    def one(
        name: str,
        model: str,
        schedules: list[Schedule],
        *,
        traversal: str | None = None,
        counted: bool = False,
    ) -> tuple[Left, list[Left]]:
        program = PROGRAM.format(
            scenes=str(Path(__file__).parents[2] / "scenes"),
            name=name,
            model=model,
            schedules=json.dumps(schedules),
            traversal=traversal,
            counted=counted,
        )
        rows = json.loads(run(program)[-1])
        processor, *found = (Left(*row) for row in rows)
        return processor, found

    return one


@pytest.mark.parametrize(
    ("name", "model", "traversal"),
    [
        ("three-spheres", "haste", None),
        ("mirror-glass", "whitted", "bvh2"),
        ("mirror-glass", "path", "bvh2"),
    ],
)
def test_every_engine_gives_the_processors_film_and_all_its_memory_back(
    render: Render, name: str, model: str, traversal: str | None
):
    processor, found = render(name, model, SCHEDULES, traversal=traversal)
    for schedule, left in zip(SCHEDULES, found, strict=True):
        assert left.film == processor.film, f"another film than the processor's with {schedule}"
        assert left.peak <= schedule.get("queue_bytes", 1 << 40), f"{left.peak} with {schedule}"
        assert left.lives[0] == left.lives[1], f"{left.lives} things live with {schedule}"


def test_every_engine_counts_the_rays_of_the_processor(render: Render):
    schedules: list[Schedule] = [{"engine": engine} for engine in ENGINES]
    processor, found = render("three-spheres", "haste", schedules, counted=True)
    assert min(processor.counts) > 0
    counts = {engine: left.counts for engine, left in zip(ENGINES, found, strict=True)}
    assert all(count == processor.counts for count in counts.values()), f"{counts}"


def test_a_sum_that_leaves_the_films_range_is_refused_by_every_engine(
    run: Callable[[str], list[str]],
):
    lines = run(BRIM.format(engines=ENGINES))
    fits = [f"0.0 {engine} fits" for engine in ENGINES]
    assert lines[: len(ENGINES)] == fits
    for engine, line in zip(ENGINES, lines[len(ENGINES) :], strict=True):
        assert line.startswith(f"0.9 {engine} the film overflows at pixel (0, 0)"), line


def test_a_lost_block_of_threads_is_another_film(render: Render, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("EMULATION_FAULT", "lost block")
    processor, (left,) = render("three-spheres", "haste", [{"engine": "packets", "packet": 512}])
    assert left.film != processor.film


def test_memory_that_is_not_given_back_is_seen(render: Render, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("EMULATION_FAULT", "lost memory")
    _, (left,) = render("three-spheres", "haste", [{"engine": "packets", "packet": 512}])
    assert left.lives[0] < left.lives[1]
