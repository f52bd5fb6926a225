"""Every engine on the GPU gives the film of `depth_first`, bit for bit, however it is scheduled."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from haste_cuda._core import testing

import haste_cuda
from harness.scene import load_scene, load_settings
from harness.tracers.haste import to_core, to_core_settings

pytestmark = pytest.mark.gpu

SCENES = Path(__file__).parents[2] / "scenes"
NAMES = ("cornell-box", "three-spheres", "skull", "mirror-glass", "hard")
MODELS = ("haste", "whitted", "path")
ENGINES = ("depth_first", "packets", "streams", "layers", "wavefront", "persistent")
QUEUES = ("packets", "streams", "layers", "wavefront")
PACKETS = (256, 4096, 65536, 1 << 20)
SIZE = 40
SAMPLES = 4
RAYS = ("camera", "shadow", "ambient", "bounce")


class Renders:
    """One scene in one model, with its own settings but for `changes`."""

    def __init__(self, name: str, model: str, **changes: int) -> None:
        own = load_settings(SCENES / name).render(model, SIZE, SIZE)
        self.settings = to_core_settings(replace(own, **changes))
        self.scene = to_core(load_scene(SCENES / name, width=SIZE, height=SIZE), 2)
        self.model = model

    def __call__(self, engine: str = "depth_first", **schedule: Any) -> dict[str, Any]:
        return haste_cuda.render_cuda(
            *(self.scene, self.model, self.settings),
            engine=engine,
            **{"seed": 7, "samples": SAMPLES, **schedule},
        )


@pytest.fixture(scope="module", params=[(n, m) for n in NAMES for m in MODELS], ids="-".join)
def render(request: pytest.FixtureRequest) -> Renders:
    """Every scene in every model."""
    return Renders(*request.param)


def schedules() -> list[dict[str, Any]]:
    """Every engine with every setting that must not change a bit."""
    cases: list[dict[str, Any]] = [
        {"engine": engine, "block": block} for engine in ENGINES for block in (64, 128, 256)
    ]
    for packet in PACKETS:
        cases += [{"engine": engine, "packet": packet} for engine in QUEUES]
        cases += [
            {"engine": engine, "packet": packet, "order": "lifo"}
            for engine in ("packets", "streams")
        ]
        cases += [
            {"engine": "packets", "packet": packet, "allocation": "per_packet"},
            *(
                {"engine": engine, "packet": packet, "streams": streams}
                for engine in ("streams", "wavefront")
                for streams in (1, 6)
            ),
        ]
    cases += [
        {"engine": engine, "packet": 4096, "order": order, "queue_bytes": 1 << 20}
        for engine in QUEUES
        for order in ("fifo", "lifo")
    ]
    return cases


def test_the_film_does_not_depend_on_the_schedule(render: Renders):
    film = render()["film_sha256"]
    different = [case for case in schedules() if render(**case)["film_sha256"] != film]
    assert not different, f"another film with {different}"


@pytest.mark.parametrize("engine", ENGINES)
def test_three_runs_give_one_film(render: Renders, engine: str):
    assert len({render(engine)["film_sha256"] for _ in range(3)}) == 1


def test_every_engine_traces_the_same_rays(render: Renders):
    counts = {
        engine: [render(engine, count_rays=True)[rays] for rays in RAYS] for engine in ENGINES
    }
    assert all(count == counts["depth_first"] for count in counts.values()), f"{counts}"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_film_of_floats_is_that_of_integers_but_for_rounding(render: Renders, engine: str):
    """n float32 additions of a pixel err by n ulp / 2 of its sum; a pixel gets below 4096 here."""
    integers = render(engine)["film"]
    answer = render(engine, film="float_atomic")
    assert answer["film_sha256"] is None
    assert np.abs(answer["film"] - integers).max() <= 4096 * 2.0**-24 * integers.max()


@pytest.mark.parametrize("model", ["haste", "whitted"])
def test_layers_weighted_afterwards_are_the_flat_sum_where_one_reflectance_holds(model: str):
    """Float32 products along a ray against one product at the end: half an ulp a layer."""
    render = Renders("three-spheres", model)
    flat = render("layers")["film"]
    weighted = render("layers", accumulation="layer_weighted")["film"]
    assert np.abs(weighted - flat).max() <= 1e-6 * flat.max()


def test_layers_weighted_afterwards_are_wrong_where_reflectances_differ():
    render = Renders("mirror-glass", "whitted")
    means = {
        kind: np.array(
            [render("layers", accumulation=kind, seed=s)["film"].mean() for s in range(8)]
        )
        for kind in ("flat", "layer_weighted")
    }
    flat, weighted = means["flat"], means["layer_weighted"]
    error = np.sqrt((flat.var(ddof=1) + weighted.var(ddof=1)) / len(flat))
    assert abs(flat.mean() - weighted.mean()) > 10 * error


@pytest.mark.parametrize("order", ["fifo", "lifo"])
@pytest.mark.parametrize("engine", QUEUES)
def test_sixteen_megabytes_are_enough(render: Renders, engine: str, order: str):
    answer = render(engine, order=order, packet=65536, queue_bytes=16 << 20)
    assert answer["film_sha256"] == render()["film_sha256"]
    assert answer["peak_queue_bytes"] <= 16 << 20


@pytest.mark.parametrize("model", ["haste", "whitted"])
@pytest.mark.parametrize("engine", QUEUES)
def test_sixteen_layers_of_glass_keep_their_bits_in_any_room(engine: str, model: str):
    render = Renders("mirror-glass", model, max_layers=16)
    film = render("persistent")["film_sha256"]
    assert render()["film_sha256"] == film
    for limit in (16 << 20, 1 << 20, 1 << 16):
        packet = min(65536, limit // testing.ray_bytes)
        for order in ("fifo", "lifo"):
            answer = render(engine, order=order, packet=packet, queue_bytes=limit)
            assert answer["film_sha256"] == film, f"{order} {limit}"
            assert answer["peak_queue_bytes"] <= limit


@pytest.mark.parametrize(
    ("schedule", "names"),
    [
        ({"engine": "packets", "packet": 0}, "packet must hold at least 1 ray"),
        ({"engine": "wavefront", "packet": 64, "queue_bytes": 4095}, "to hold one packet"),
        ({"engine": "streams", "streams": 0}, "streams must be 1"),
        ({"engine": "packets", "allocation": "never"}, "allocation must be one of"),
        ({"film": "half"}, "film must be one of"),
        ({"block": 48}, "block must be a multiple of 32"),
        ({"accumulation": "layer_weighted"}, "belongs to the engine layers"),
    ],
    ids=str,
)
def test_a_schedule_that_makes_no_sense_is_refused(schedule: dict[str, Any], names: str):
    with pytest.raises(ValueError, match=names):
        Renders("cornell-box", "path")(**schedule)


@pytest.mark.parametrize("engine", QUEUES)
def test_a_device_out_of_memory_says_so_and_stays_usable(engine: str):
    """2^28 rays are 16 GiB, and their 64 ambient rays a TiB."""
    render = Renders("mirror-glass", "haste", ambient_samples=64)
    film = render(engine)["film_sha256"]
    with pytest.raises(haste_cuda.CudaError, match="out of memory"):
        render(engine, packet=1 << 28, queue_bytes=1 << 44)
    assert render(engine)["film_sha256"] == film
