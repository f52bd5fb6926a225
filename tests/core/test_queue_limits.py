"""A queue with few bytes throttles: the film keeps its bits, and nothing fails."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from haste_cuda._core import testing

import haste_cuda
from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

SCENES = sorted(
    path.parent
    for path in Path(__file__).parents[2].glob("scenes/*/scene.xml")
    # A queue does not know how many triangles there are: smaller ones stand for these.
    if path.parent.name not in ("bumpy-262k", "bumpy-4m", "menger-4")
)
SIZE = 24
MODELS = ["path", "haste", "whitted"]
HOST_QUEUES = [("packets", "fifo"), ("packets", "lifo"), ("layers", "fifo")]


@cache
def scene_of(folder: Path) -> haste_cuda.Scene:
    return to_core(load_scene(folder, width=SIZE, height=SIZE), 2)


class Renders:
    """One scene in one model, with its own settings but for `changes`."""

    def __init__(self, folder: Path, model: str, **changes: int) -> None:
        own = load_settings(folder).render(model, SIZE, SIZE)
        self.settings = to_core_settings(replace(own, **changes))
        self.scene = scene_of(folder)
        self.model = model

    def __call__(self, **schedule: Any) -> dict[str, Any]:
        return haste_cuda.render_cpu(
            *(self.scene, self.model, self.settings), seed=5, samples=2, **schedule
        )


def folder_of(name: str) -> Path:
    return next(folder for folder in SCENES if folder.name == name)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("folder", SCENES, ids=lambda path: path.name)
def test_sixteen_megabytes_are_enough_for_every_scene(folder: Path, model: str) -> None:
    if model not in load_settings(folder).models:
        pytest.skip("not among the models of the scene")
    render = Renders(folder, model)
    film = render()["film_sha256"]
    for engine, order in HOST_QUEUES:
        answer = render(engine=engine, order=order, queue_bytes=16 << 20)
        assert answer["film_sha256"] == film, f"{engine} {order}"
        assert answer["peak_queue_bytes"] <= 16 << 20


@pytest.mark.parametrize("model", ["haste", "whitted"])
def test_sixteen_layers_of_glass_keep_their_bits_in_any_room(model: str) -> None:
    """From 16 MB down to what a single sample needs."""
    render = Renders(folder_of("mirror-glass"), model, max_layers=16)
    film = render()["film_sha256"]
    for limit in (16 << 20, 1 << 20, 1 << 16, 1 << 13):
        for engine, order in HOST_QUEUES:
            packet = min(65536, limit // testing.ray_bytes)
            answer = render(engine=engine, order=order, packet=packet, queue_bytes=limit)
            assert answer["film_sha256"] == film, f"{engine} {order} {limit}"
            assert answer["peak_queue_bytes"] <= limit


def test_any_packet_and_limit_that_are_accepted_give_the_same_film() -> None:
    choose = random.Random(4)
    render = Renders(folder_of("mirror-glass"), "haste")
    film = render()["film_sha256"]
    for _ in range(20):
        limit = int(2 ** choose.uniform(11, 22))
        packet = choose.randint(1, limit // testing.ray_bytes)
        engine, order = choose.choice(HOST_QUEUES)
        answer = render(engine=engine, order=order, packet=packet, queue_bytes=limit)
        case = f"{engine} {order} packet {packet} limit {limit}"
        assert answer["film_sha256"] == film, case
        assert answer["peak_queue_bytes"] <= limit, case


@pytest.mark.parametrize("engine", ["packets", "layers"])
def test_a_queue_too_small_for_one_sample_is_refused_with_the_bytes_it_needs(engine: str) -> None:
    render = Renders(folder_of("mirror-glass"), "whitted", max_layers=16)
    with pytest.raises(ValueError, match="queue_bytes must be at least") as raised:
        render(engine=engine, packet=1, queue_bytes=512)
    needed = int(re.search(r"at least (\d+)", str(raised.value))[1])
    render(engine=engine, packet=1, queue_bytes=needed)
    with pytest.raises(ValueError, match="queue_bytes"):
        render(engine=engine, packet=1, queue_bytes=needed - testing.ray_bytes)


@pytest.mark.parametrize(
    ("schedule", "names"),
    [
        ({"engine": "packets", "packet": 0}, "packet must hold at least 1 ray"),
        ({"engine": "packets", "packet": 64, "queue_bytes": 4095}, "to hold one packet"),
        ({"engine": "packets", "packet": 1 << 40}, "packet must hold at most"),
        ({"engine": "packets", "order": "random"}, "order must be one of fifo, lifo"),
        ({"engine": "streams"}, "engine must be one of"),
        ({"accumulation": "layer_weighted"}, "belongs to the engine layers"),
        ({"engine": "layers", "accumulation": "layer_weighted"}, "which path has not"),
        ({"intersector": "embree", "engine": "packets"}, "depth_first only"),
    ],
    ids=str,
)
def test_a_schedule_that_makes_no_sense_is_refused(schedule: dict[str, Any], names: str) -> None:
    with pytest.raises(ValueError, match=names):
        Renders(folder_of("cornell-box"), "path")(**schedule)


@pytest.mark.parametrize("count", [0, 65536])
@pytest.mark.parametrize("setting", ["light_samples", "ambient_samples"])
def test_counts_of_samples_that_no_ray_tree_can_have_are_refused(setting: str, count: int) -> None:
    with pytest.raises(ValueError, match=setting):
        Renders(folder_of("mirror-glass"), "haste", **{setting: count})()


def test_layers_weighted_afterwards_are_those_of_rays_that_carry_their_weight() -> None:
    """Equation 8 against equation 9: the same sum where one reflectance is the whole scene's.

    The film has rounded each layer to its unit, 2^-63 of its range, before the weight; the sums of
    rays that carry float32 products differ by half an ulp a layer, 1e-6 of a pixel is generous.
    """
    folder = folder_of("three-spheres")
    materials = load_scene(folder, width=SIZE, height=SIZE).materials
    assert {m.reflection for m in materials} == {0.0, 0.25}
    assert not any(m.transmission for m in materials)
    render = Renders(folder, "whitted")
    flat = render(engine="layers")["film"]
    weighted = render(engine="layers", accumulation="layer_weighted")["film"]
    assert np.abs(weighted - flat).max() <= 1e-6 * flat.max()


def test_layers_weighted_afterwards_are_wrong_where_reflectances_differ() -> None:
    """The negative control, and the reason for the paper's equation 9."""
    folder = folder_of("mirror-glass")
    films = {
        accumulation: np.array(
            [
                haste_cuda.render_cpu(
                    *(render.scene, render.model, render.settings),
                    seed=seed,
                    samples=4,
                    engine="layers",
                    accumulation=accumulation,
                )["film"].mean()
                for seed in range(8)
            ]
        )
        for render in [Renders(folder, "whitted")]
        for accumulation in ("flat", "layer_weighted")
    }
    flat, weighted = films["flat"], films["layer_weighted"]
    error = np.sqrt((flat.var(ddof=1) + weighted.var(ddof=1)) / len(flat))
    assert abs(flat.mean() - weighted.mean()) > 10 * error
