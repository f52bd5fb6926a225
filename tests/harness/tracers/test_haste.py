"""The tracers on the compiled core, on a real scene."""

from dataclasses import replace

import numpy as np
import pytest

from harness.measure.config import ROOT
from harness.scene import load_settings
from harness.tracers.haste import Embree, HasteCpu

SCENE = ROOT / "scenes" / "three-spheres"
REASON = HasteCpu.unavailable()

pytestmark = pytest.mark.skipif(REASON is not None, reason=REASON or "")


@pytest.mark.parametrize("model", ["path", "haste", "whitted"])
def test_packets_give_the_film_of_the_plain_engine(model: str):
    tracer = HasteCpu(2)
    times = tracer.load(SCENE, load_settings(SCENE).render(model, 16, 16))
    assert times["build_seconds"] > 0.0 and times["bvh_bytes"] > 0.0, times
    assert len(tracer.hashes["bvh_sha256"]) == 64
    plain = tracer.render(3, 4)
    packets = tracer.render(3, 4, engine="packets", options={"packet": 64, "order": "lifo"})
    assert plain.image.shape == (16, 16, 3) and plain.image.dtype == np.float64
    assert plain.film_sha256 == packets.film_sha256, model
    assert np.array_equal(plain.image, packets.image), model
    assert packets.extras["peak_queue_bytes"] > 0.0, packets.extras


def test_rays_are_counted_only_when_asked_and_change_no_pixel():
    tracer = HasteCpu(1)
    tracer.load(SCENE, load_settings(SCENE).render("haste", 16, 16))
    timed, counted = tracer.render(0, 4), tracer.render(0, 4, count_rays=True)
    assert timed.rays is None
    assert counted.rays is not None
    assert counted.rays.camera == 16 * 16 * 4, counted.rays
    assert counted.rays.shadow > counted.rays.camera, counted.rays
    assert counted.rays.ambient > 0 and counted.rays.bounce > 0, counted.rays
    assert timed.film_sha256 == counted.film_sha256


def test_embree_tells_the_build_time_of_its_own_hierarchy():
    tracer = Embree(1)
    times = tracer.load(SCENE, load_settings(SCENE).render("path", 16, 16))
    assert times["build_seconds"] > 0.0 and "bvh_nodes" not in times, times
    image = tracer.render(1, 2).image
    assert np.isfinite(image).all() and image.mean() > 0.0


CORNELL = ROOT / "scenes" / "cornell-box"


def loaded(model: str, **changes: int) -> HasteCpu:
    """The Cornell box in a tracer, with settings of its own."""
    tracer = HasteCpu(2)
    tracer.load(CORNELL, replace(load_settings(CORNELL).render(model, 16, 16), **changes))
    return tracer


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("path", {"max_depth": 3}),
        ("path", {"max_depth": 12, "rr_depth": 2}),
        ("haste", {"light_samples": 1, "ambient_samples": 2}),
    ],
)
def test_a_turned_knob_gives_the_film_of_a_scene_loaded_with_it(
    model: str, changes: dict[str, int]
):
    turned = loaded(model).render(5, 4, options=changes)
    assert turned.film_sha256 == loaded(model, **changes).render(5, 4).film_sha256
    assert turned.film_sha256 != loaded(model).render(5, 4).film_sha256, "nothing was turned"


def test_a_clamp_that_no_light_reaches_changes_no_bit():
    tracer = loaded("path")
    assert (
        tracer.render(1, 16, options={"clamp": 1e6}).film_sha256 == tracer.render(1, 16).film_sha256
    )


def test_a_clamp_leaves_direct_light_alone():
    tracer = loaded("path", max_depth=2)
    assert (
        tracer.render(1, 16, options={"clamp": 1e-3}).film_sha256
        == tracer.render(1, 16).film_sha256
    )


def test_a_clamp_takes_light_away_and_bounds_what_a_path_brings():
    tracer = loaded("path")
    direct = tracer.render(1, 16, options={"max_depth": 2}).image
    whole = tracer.render(1, 16).image
    limit = 0.01
    clamped = tracer.render(1, 16, options={"clamp": limit}).image
    assert (clamped <= whole).all() and clamped.mean() < 0.99 * whole.mean()
    # A path of 8 segments has 12 contributions of indirect light: emitters sampled from surfaces 2
    # to 7, and met by chance at the end of segments 3 to 8. Rounding to the film's unit may go up.
    assert (clamped - direct).sum(axis=-1).max() <= 12.001 * limit
    packets = tracer.render(1, 16, engine="packets", options={"clamp": limit, "packet": 64})
    assert np.array_equal(packets.image, clamped), "no engine knows of the clamp"
