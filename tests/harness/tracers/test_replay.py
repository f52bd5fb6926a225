"""Rays through every tracer: one interface, the same hits, and clear refusals."""

from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from harness.measure.config import ROOT
from harness.scene import RenderSettings, load_scene, load_settings
from harness.tracers import NONE, TRACERS, RayHits, RenderResult, Tracer, UnsupportedError
from harness.tracers.rays import Query, Way, make_rays
from harness.tracers.registry import load_tracer

SCENES = ("cornell-box", "mirror-glass", "three-spheres")
COUNT = 5000
ONE_BY_ONE = 500
"""Rays of a tracer that takes one a call."""

Rays = tuple[NDArray[np.float32], NDArray[np.float32]]


def rays_through(name: str) -> Rays:
    """Rays from the camera of a scene to points all over it, directions of any length."""
    scene = load_scene(ROOT / "scenes" / name)
    random = np.random.default_rng(40)
    points = np.concatenate([scene.vertices, scene.spheres[:, :3]])
    targets = random.uniform(points.min(axis=0), points.max(axis=0), (COUNT, 3))
    origins = np.tile(np.array(scene.camera.origin), (COUNT, 1))
    towards = (targets - origins) * random.uniform(0.1, 3.0, (COUNT, 1))
    return origins.astype(np.float32), towards.astype(np.float32)


def loaded(tracer: str, scene: str) -> Tracer:
    """A tracer with a scene, or a skipped test with the reason."""
    kind = load_tracer(TRACERS[tracer])
    reason = kind.unavailable()
    if reason is not None:
        pytest.skip(reason)
    one = kind(2)
    folder = ROOT / "scenes" / scene
    try:
        one.load(folder, load_settings(folder).render("path", 8, 8))
    except UnsupportedError as refusal:
        pytest.skip(str(refusal))
    return one


@pytest.fixture(scope="module", params=SCENES)
def expected(request: pytest.FixtureRequest) -> tuple[str, Rays, RayHits]:
    """A scene's name, rays, and what haste-cpu sees."""
    rays = rays_through(request.param)
    return request.param, rays, loaded("haste-cpu", request.param).trace(*rays)


@pytest.mark.parametrize("name", [name for name in TRACERS if name != "haste-cpu"])
def test_every_tracer_sees_the_same(expected: tuple[str, Rays, RayHits], name: str):
    scene, rays, ours = expected
    tracer = loaded(name, scene)
    count = ONE_BY_ONE if name == "mitsuba-scalar" else COUNT
    some = (rays[0][:count], rays[1][:count])
    hits = tracer.trace(*some)
    assert hits.t.dtype == np.float32 and hits.shape.dtype == hits.primitive.dtype == np.uint32
    for part in ("hit", "shape", "primitive"):
        differ = getattr(hits, part) != getattr(ours, part)[:count]
        # A ray in five thousand may pass through an edge within rounding.
        assert differ.sum() <= 1, f"{scene} {name} {part}: rays {np.flatnonzero(differ)[:5]}"
    same = hits.hit & (hits.primitive == ours.primitive[:count])
    # Mitsuba's quadratic loses half of the digits of a sphere's t at its silhouette.
    np.testing.assert_allclose(hits.t[same], ours.t[:count][same], rtol=2.0**-9)
    assert np.median(np.abs(hits.t[same] / ours.t[:count][same] - 1.0)) < 2.0**-20
    found = tracer.trace(*some, any_hit=True)
    assert (found.hit != hits.hit).sum() <= 1, f"{scene} {name}"
    assert (found.t[found.hit] == 0.0).all() and (found.shape == NONE).all()


@pytest.mark.parametrize("name", list(TRACERS))
def test_t_min_leads_to_the_next_surface_and_t_max_ends_the_ray(name: str):
    tracer = loaded(name, "cornell-box")
    # Through the short block from the front: its face, its back, then the wall behind it.
    box = load_scene(ROOT / "scenes" / "cornell-box")
    block = next(shape for shape in box.shapes if shape.name == "short-block")
    corners = box.vertices[box.triangles[block.first : block.first + block.count]]
    middle = corners.reshape(-1, 3).mean(axis=0)
    origin = np.tile(np.array(box.camera.origin, np.float32), (4, 1))
    towards = np.tile((middle - origin[0]).astype(np.float32), (4, 1))
    first = tracer.trace(origin, towards)
    assert box.shapes[first.shape[0]].name == "short-block"
    t = float(first.t[0])
    start = np.array([0.0, 1.01 * t, 0.0, 0.0], np.float32)
    end = np.array([np.inf, np.inf, 0.99 * t, 1.01 * t], np.float32)
    hits = tracer.trace(origin, towards, start, end)
    assert hits.t[0] == first.t[0]
    assert hits.t[1] > start[1] and hits.primitive[1] not in (first.primitive[0], NONE), hits
    assert not hits.hit[2] and hits.primitive[2] == hits.shape[2] == NONE, hits
    assert hits.t[3] == first.t[0]
    found = tracer.trace(origin, towards, start, end, any_hit=True)
    assert found.hit.tolist() == [True, True, False, True]


@pytest.mark.parametrize("name", ["haste-cpu", "embree", "mitsuba-llvm", "haste-cuda"])
def test_the_time_is_that_of_tracing_alone(name: str):
    tracer = loaded(name, "cornell-box")
    rays = rays_through("cornell-box")
    tracer.trace(*rays)
    assert 0.0 < tracer.trace(*rays).seconds < np.inf


@pytest.mark.parametrize("name", ["haste-cpu", "embree", "mitsuba-llvm", "haste-cuda"])
def test_every_repeat_has_a_time_and_the_hits_of_the_first(name: str):
    tracer = loaded(name, "cornell-box")
    rays = rays_through("cornell-box")
    once, often = tracer.trace(*rays), tracer.trace(*rays, repeats=3)
    assert len(often.times) == 3 and min(often.times) > 0.0 and often.seconds == often.times[-1]
    assert np.array_equal(once.t, often.t) and np.array_equal(once.primitive, often.primitive)


@pytest.mark.parametrize("name", ["haste-cpu", "haste-cuda"])
def test_every_traversal_of_the_core_gives_the_same_hits(name: str):
    tracer = loaded(name, "three-spheres")
    rays = rays_through("three-spheres")
    expected = tracer.trace(*rays)
    for way in tracer.ways():
        hits = tracer.trace(*rays, way=way)
        if way.precision == "fast":
            # A ray in some thousand may pass through an edge, and distances round in another way.
            assert (hits.primitive != expected.primitive).mean() < 1e-3, way
            continue
        assert np.array_equal(hits.t, expected.t), way
        assert np.array_equal(hits.primitive, expected.primitive), way
        structure = tracer.structure(way)
        assert structure is not None, way
        assert (structure.size > 0.0) == (way.traversal != "brute_force"), (way, structure)


@pytest.mark.parametrize("name", list(TRACERS))
def test_rays_that_are_held_are_traced_again_and_again(name: str):
    tracer = loaded(name, "cornell-box")
    origins, towards = (part[:ONE_BY_ONE] for part in rays_through("cornell-box"))
    first = tracer.trace(origins, towards)
    held = tracer.hold(make_rays(origins, towards))
    assert len(held) == ONE_BY_ONE
    way = tracer.ways()[0]
    for turn in range(2):
        again = tracer.replay(held, way, Query())
        for part in ("t", "shape", "primitive"):
            assert np.array_equal(getattr(again, part), getattr(first, part)), (name, turn, part)
        # What lies beyond the ends of the arrays that are handed back would show here.
        found = tracer.replay(held, way, Query(any_hit=True))
        assert np.array_equal(found.hit, first.hit), (name, turn)


@pytest.mark.parametrize("name", ["haste-cpu", "embree", "mitsuba-llvm", "haste-cuda"])
def test_hits_that_are_not_asked_for_are_not_handed_back(name: str):
    tracer = loaded(name, "cornell-box")
    held = tracer.hold(make_rays(*rays_through("cornell-box")))
    for any_hit in (False, True):
        timed = tracer.replay(held, tracer.ways()[0], Query(any_hit, repeats=3, hits=False))
        assert len(timed.t) == len(timed.shape) == len(timed.primitive) == 0, timed
        assert len(timed.times) == 3 and min(timed.times) > 0.0, timed


def test_a_way_that_a_tracer_does_not_have_is_refused():
    tracer = loaded("haste-cpu", "cornell-box")
    with pytest.raises(UnsupportedError, match="haste-cpu has no traversal octree, watertight"):
        tracer.trace(ORIGINS, TOWARDS, way=Way("octree", "watertight"))


def test_embree_sees_the_same_in_every_call_and_mode():
    tracer = loaded("embree", "cornell-box")
    rays = rays_through("cornell-box")
    # Not a multiple of a packet: the last one has lanes without a ray.
    some = (rays[0][:4997], rays[1][:4997])
    expected = tracer.trace(*some)
    for way in tracer.ways():
        try:
            hits = tracer.trace(*some, way=way)
        except UnsupportedError:
            # Packets of 16 need registers of 512 bits; all processors that are meant have the rest.
            assert way.traversal == "intersect16"
            continue
        # In the fast mode a ray in five thousand may pass through an edge.
        differ = hits.primitive != expected.primitive
        assert differ.sum() <= 1, (way, np.flatnonzero(differ)[:5])
        np.testing.assert_allclose(hits.t[~differ], expected.t[~differ], rtol=2.0**-16)
        found = tracer.trace(*some, way=way, any_hit=True)
        assert (found.hit != expected.hit).sum() <= 1, way
        assert (found.t[found.hit] == 0.0).all(), way
        structure = tracer.structure(way)
        assert structure is not None, way
        assert (structure.size > 0.0) == (way.traversal != "brute_force"), (way, structure)


def test_packets_are_refused_where_embree_would_hand_them_to_a_callback_of_one_ray():
    tracer = loaded("embree", "three-spheres")
    with pytest.raises(UnsupportedError, match="packets are not traced through spheres"):
        tracer.trace(ORIGINS, TOWARDS, way=Way("intersect8", "robust"))
    assert len(tracer.trace(ORIGINS, TOWARDS, way=Way("intersect1", "fast")).t) == 2


def test_a_call_a_ray_has_no_time():
    tracer = loaded("mitsuba-scalar", "cornell-box")
    origins, towards = rays_through("cornell-box")
    assert np.isnan(tracer.trace(origins[:3], towards[:3]).seconds)


class Mute(Tracer):
    """A tracer that renders and nothing else."""

    name: ClassVar[str] = "mute"
    precision: ClassVar[str] = "native"

    @classmethod
    def unavailable(cls) -> str | None:
        return None

    def load(self, scene_path: Path, settings: RenderSettings) -> dict[str, float]:
        del scene_path, settings
        return {}

    def render(self, seed: int, spp: int, **rest: object) -> RenderResult:
        del seed, spp, rest
        return RenderResult(np.zeros((1, 1, 3)), 0.0)


ORIGINS, TOWARDS = np.zeros((2, 3), np.float32), np.ones((2, 3), np.float32)


def test_a_tracer_without_the_query_refuses_it():
    with pytest.raises(UnsupportedError, match="mute traces no rays but those of its own images"):
        Mute(1).trace(ORIGINS, TOWARDS)


def changed(value: float) -> NDArray[np.float32]:
    """Two rows of ones, the second with `value` in it."""
    return np.array([[1, 1, 1], [1, 1, value]], np.float32)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            (np.zeros((2, 3)), TOWARDS),
            "origins must be a float32 array of shape [n, 3], not float64 [2, 3]",
        ),
        (
            (ORIGINS.T.copy(), TOWARDS),
            "origins must be a float32 array of shape [n, 3], not float32 [3, 2]",
        ),
        (
            (ORIGINS, [[0.0, 0.0, 1.0]]),
            "directions must be a float32 array of shape [n, 3], not list",
        ),
        ((ORIGINS, TOWARDS[:1]), "there are 2 origins, but 1 directions"),
        (
            (ORIGINS, TOWARDS, np.zeros(3, np.float32)),
            (
                "t_min must be a number or a float32 array of shape [2], one entry a ray, "
                "not float32 [3]"
            ),
        ),
        (
            (ORIGINS, TOWARDS, 0.0, np.ones(2)),
            (
                "t_max must be a number or a float32 array of shape [2], one entry a ray, "
                "not float64 [2]"
            ),
        ),
        ((changed(np.nan), TOWARDS), "ray 1: its origin is not finite"),
        ((ORIGINS, changed(np.inf)), "ray 1: its direction is not finite"),
        ((ORIGINS, np.array([[1, 1, 1], [0, 0, 0]], np.float32)), "ray 1: its direction is zero"),
        ((ORIGINS, TOWARDS, -1.0), "ray 0: t_min must be finite and not negative"),
        ((ORIGINS, TOWARDS, np.inf), "ray 0: t_min must be finite and not negative"),
        ((ORIGINS, TOWARDS, 2.0, 1.0), "ray 0: t_max must not be below t_min"),
        ((ORIGINS, TOWARDS, 0.0, np.nan), "ray 0: t_max must not be below t_min"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_rays_that_make_no_sense_are_refused_by_name(arguments: tuple[object, ...], message: str):
    with pytest.raises(ValueError) as refusal:  # noqa: PT011 - the whole message is compared
        make_rays(*arguments)  # type: ignore[arg-type]
    assert str(refusal.value) == message
