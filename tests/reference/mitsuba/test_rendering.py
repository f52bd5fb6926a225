from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reference.mitsuba import UnavailableVariantError, available, load, render, turn
from reference.mitsuba import rendering as module

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box"


@pytest.fixture
def scene(active: str) -> dict[str, Any]:
    del active
    import mitsuba as mi

    place = mi.ScalarTransform4f().look_at(origin=[0, -4, 1], target=[0, 0, 0.5], up=[0, 0, 1])
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": [1, 2, 3]}}
    return {
        "type": "scene",
        "sensor": {"type": "perspective", "to_world": place},
        "floor": {"type": "rectangle", "bsdf": {"type": "phong"}},
        "light": {"type": "sphere", "radius": 0.3, "center": [0, 0, 1], "emitter": emitter},
    }


def test_passes_share_the_samples_and_stay_small():
    for spp, pixels in ((1, 1), (256, 64 * 64), (1000, 512 * 512), (7, 1 << 23), (4096, 1 << 20)):
        sizes = module.pass_sizes(spp, pixels)
        assert sum(sizes) == spp and max(sizes) - min(sizes) <= 1, (spp, pixels, sizes)
        assert max(sizes) * pixels <= max(module.SAMPLES_PER_PASS, pixels), (spp, pixels, sizes)
    with pytest.raises(ValueError, match="passes"):
        module.pass_sizes(1 << 20, 1 << 22)


@pytest.mark.parametrize("model", ["path", "haste", "whitted"])
def test_an_image_is_float64_of_the_asked_size_and_depends_on_the_seed(
    scene: Any, settings: Any, active: str, model: str
):
    loaded = load(scene, settings(model, 8), active)
    image, seconds = render(loaded, 0, 4)
    assert image.shape == (8, 8, 3) and image.dtype == np.float64 and seconds > 0.0
    assert np.allclose(image, render(loaded, 0, 4)[0], rtol=1e-5)
    assert not np.allclose(image, render(loaded, 1, 4)[0], rtol=1e-5)


def test_passes_are_independent_samples_of_one_image(
    scene: Any, settings: Any, active: str, monkeypatch: pytest.MonkeyPatch
):
    loaded = load(scene, settings("haste", 8), active)
    whole = np.stack([render(loaded, seed, 64)[0].mean() for seed in range(8)])
    monkeypatch.setattr(module, "SAMPLES_PER_PASS", 64 * 10)
    parts = np.stack([render(loaded, seed, 64)[0].mean() for seed in range(8)])
    error = np.sqrt((whole.var(ddof=1) + parts.var(ddof=1)) / 8)
    assert abs(whole.mean() - parts.mean()) < 5.0 * error, (whole.mean(), parts.mean(), error)
    # Repeated streams would leave the noise of a single pass, 7 times the variance.
    assert parts.var(ddof=1) < 4.0 * whole.var(ddof=1), (whole.var(), parts.var())


def test_a_seed_compiles_nothing_anew(scene: Any, settings: Any, active: str):
    import drjit as dr

    for model in ("path", "haste", "whitted"):
        loaded = load(scene, settings(model, 8), active)
        for seed in range(2):
            render(loaded, seed, 4)
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
            dr.kernel_history_clear()
            render(loaded, 12345, 4)
            render(loaded, 1_000_007, 4)
            kernels = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
        assert kernels and all(k["cache_hit"] for k in kernels), model


@pytest.mark.parametrize(("seed", "spp"), [(-1, 1), (1 << 21, 1), (0, 0)])
def test_a_seed_or_sample_count_out_of_range_is_refused(
    scene: Any, settings: Any, active: str, seed: int, spp: int
):
    loaded = load(scene, settings("whitted", 8), active)
    with pytest.raises(ValueError, match=r"seed|spp"):
        render(loaded, seed, spp)


def test_native_path_runs_in_the_scalar_variant_and_agrees(scene: Any, settings: Any, active: str):
    native = scene | {"floor": {"type": "rectangle", "bsdf": {"type": "diffuse"}}}
    means = []
    for variant in (active, "scalar_rgb"):
        loaded = load(native, settings("path", 8), variant)
        means.append(np.stack([render(loaded, seed, 32)[0].mean() for seed in range(8)]))
    error = np.sqrt(sum(m.var(ddof=1) for m in means) / 8)
    assert abs(means[0].mean() - means[1].mean()) < 5.0 * error, (means, error)


def test_the_python_integrators_are_refused_in_scalar_variants(scene: Any, settings: Any):
    with pytest.raises(UnavailableVariantError, match="scalar"):
        load(scene, settings("haste", 8), "scalar_rgb")


def test_an_unknown_variant_is_unavailable_and_the_known_ones_are_listed():
    reason = available("llvm_ad_cmyk")
    assert reason is not None and "scalar_rgb" in reason


def test_the_plugins_work_in_xml_with_twosided(settings: Any, active: str, tmp_path: Any):
    file = tmp_path / "scene.xml"
    file.write_text(
        """<scene version="3.0.0">
            <sensor type="perspective">
                <transform name="to_world">
                    <lookat origin="0, 0, -3" target="0, 0, 0" up="0, 1, 0"/>
                </transform>
            </sensor>
            <bsdf type="twosided" id="both">
                <bsdf type="phong">
                    <rgb name="diffuse_reflectance" value="0.2, 0.4, 0.6"/>
                    <rgb name="specular_reflectance" value="0.3"/>
                    <float name="exponent" value="20"/>
                </bsdf>
            </bsdf>
            <shape type="rectangle"><ref id="both"/></shape>
            <shape type="rectangle">
                <transform name="to_world"><translate z="-5"/></transform>
                <emitter type="area"><rgb name="radiance" value="2"/></emitter>
            </shape>
        </scene>"""
    )
    for model in ("path", "haste", "whitted"):
        image, _ = render(load(file, settings(model, 8), active), 0, 16)
        # The camera looks at the back of the wall; the light behind the camera faces it.
        assert image[4, 4, 2] > image[4, 4, 0] > 0.0, (model, image[4, 4])


def test_an_integrator_of_other_settings_is_that_of_a_scene_loaded_with_them(
    settings: Any,
):
    loaded = load(CORNELL, settings("path"), "scalar_rgb")
    turned = turn(loaded, max_depth=3, rr_depth=2)
    assert turned.settings == settings("path", max_depth=3, rr_depth=2)
    again = load(CORNELL, turned.settings, "scalar_rgb")
    image, _ = render(turned, seed=1, spp=4)
    assert np.array_equal(image, render(again, seed=1, spp=4)[0])
    assert not np.array_equal(image, render(loaded, seed=1, spp=4)[0]), "nothing was turned"
