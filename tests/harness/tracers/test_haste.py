"""The tracers on the compiled core, on a real scene."""

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
