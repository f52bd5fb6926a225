from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from reference.mitsuba import load, render

pytestmark = pytest.mark.usefixtures("active")


def rgb(value: float | tuple[float, float, float]) -> dict[str, Any]:
    return {"type": "rgb", "value": [value] * 3 if isinstance(value, float) else list(value)}


def phong(**parameters: Any) -> dict[str, Any]:
    colours = ("diffuse_reflectance", "specular_reflectance", "ambient_reflectance")
    return {"type": "phong", "diffuse_reflectance": rgb(0.0)} | {
        key: rgb(value) if key in colours else value for key, value in parameters.items()
    }


def interaction(wi: np.ndarray) -> Any:
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, wi.shape[1])
    si.wi = mi.Vector3f(wi)
    return si


def samples(bsdf: Any, wi: tuple[float, float, float], count: int, seed: int) -> tuple[Any, Any]:
    """`count` samples of a BSDF from one direction."""
    import mitsuba as mi

    direction = np.asarray(wi, dtype=np.float64)
    direction /= np.linalg.norm(direction)
    si = interaction(np.repeat(direction[:, None], count, axis=1).astype(np.float32))
    generator = np.random.default_rng(seed)
    u = generator.random((3, count)).astype(np.float32)
    u = np.minimum(u, np.float32(1.0 - 2.0**-24))
    return bsdf.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1:]), True)


@pytest.mark.parametrize("exponent", [1.0, 30.0, 1000.0])
@pytest.mark.parametrize(("diffuse", "specular"), [(0.0, 0.5), (0.4, 0.3)])
@pytest.mark.parametrize("wi", [(0.5, 0.2, 0.8), (0.8, -0.5, 0.3)])
def test_directions_are_sampled_with_the_density_that_is_told(
    exponent: float, diffuse: float, specular: float, wi: tuple[float, float, float]
):
    import drjit as dr
    import mitsuba as mi
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain

    parameters = (
        f'<rgb name="diffuse_reflectance" value="{diffuse}, {diffuse}, {diffuse}"/>'
        f'<rgb name="specular_reflectance" value="{specular}, {specular}, {specular}"/>'
        f'<float name="exponent" value="{exponent}"/>'
    )
    sample, density = BSDFAdapter("phong", parameters, wi=dr.normalize(mi.ScalarVector3f(*wi)))
    test = ChiSquareTest(
        domain=SphericalDomain(),
        sample_func=sample,
        pdf_func=density,
        sample_dim=3,
        sample_count=300_000,
        res=151,
        ires=8,
    )
    test.write_data = lambda *_args, **_kwargs: None
    # 12 tests of this kind share a significance level of 1 %.
    passed = test.run(significance_level=0.01, test_count=12, quiet=True)
    assert passed, f"exponent {exponent}, wi {wi}: {test.messages}"


def test_the_density_test_rejects_a_lobe_that_is_a_tenth_too_sharp():
    import mitsuba as mi
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain

    def adapter(exponent: float) -> tuple[Any, Any]:
        parameters = (
            '<rgb name="diffuse_reflectance" value="0, 0, 0"/>'
            '<rgb name="specular_reflectance" value="0.5, 0.5, 0.5"/>'
            f'<float name="exponent" value="{exponent}"/>'
        )
        return BSDFAdapter("phong", parameters, wi=mi.ScalarVector3f(0.0, 0.6, 0.8))

    test = ChiSquareTest(
        domain=SphericalDomain(),
        sample_func=adapter(33.0)[0],
        pdf_func=adapter(30.0)[1],
        sample_dim=3,
        sample_count=300_000,
        res=151,
        ires=8,
    )
    test.write_data = lambda *_args, **_kwargs: None
    assert not test.run(significance_level=0.01, quiet=True)


@pytest.mark.parametrize("exponent", [1.0, 30.0, 1e3, 1e6])
def test_specular_albedo_at_normal_incidence_is_the_specular_colour(exponent: float):
    import mitsuba as mi

    bsdf = mi.load_dict(phong(specular_reflectance=0.6, exponent=exponent))
    _, weight = samples(bsdf, (0.0, 0.0, 1.0), 200_000, seed=7)
    weights = np.asarray(weight.x, dtype=np.float64)
    mean, error = weights.mean(), weights.std() / np.sqrt(weights.size)
    assert abs(mean - 0.6) < 4.0 * error + 1e-6, f"{mean} +- {error}"


@pytest.mark.parametrize("exponent", [1.0, 30.0, 1e3])
@pytest.mark.parametrize("cosine", [0.9, 0.5, 0.1])
def test_specular_albedo_is_its_quadrature_and_below_the_specular_colour(
    exponent: float, cosine: float
):
    import mitsuba as mi

    bsdf = mi.load_dict(phong(specular_reflectance=1.0, exponent=exponent))
    sine = np.sqrt(1.0 - cosine**2)
    _, weight = samples(bsdf, (sine, 0.0, cosine), 200_000, seed=8)
    weights = np.asarray(weight.x, dtype=np.float64)
    mean, error = weights.mean(), weights.std() / np.sqrt(weights.size)
    # Midpoints in the lobe's own parameters: u = cos^(alpha + 1) about R, and the azimuth.
    u, phi = (np.arange(2000) + 0.5) / 2000, (np.arange(720) + 0.5) / 720 * 2.0 * np.pi
    c = u ** (1.0 / (exponent + 1.0))
    s = np.sqrt(1.0 - c**2)
    height = c[:, None] * cosine + s[:, None] * np.cos(phi) * sine
    expected = (exponent + 2.0) / (exponent + 1.0) * np.maximum(height, 0.0).mean()
    assert abs(mean - expected) < 4.0 * error + 1e-5, f"{mean} +- {error}, not {expected}"
    assert expected < 1.0 + 1e-9


@pytest.mark.parametrize(
    ("parameters", "wi"),
    [
        ({"diffuse_reflectance": 1.0}, (0.3, 0.0, 0.7)),
        ({"reflection": 1.0}, (0.3, 0.0, 0.7)),
        ({"diffuse_reflectance": 0.5, "reflection": 0.5}, (0.3, 0.1, 0.2)),
        ({"reflection": 0.25, "transmission": 0.75}, (0.3, 0.0, 0.7)),
    ],
)
def test_no_energy_is_lost_or_gained_by_any_mixture_of_lobes(
    parameters: dict[str, Any], wi: tuple[float, float, float]
):
    import mitsuba as mi

    bsdf = mi.load_dict(phong(**parameters))
    context = mi.BSDFContext(mi.TransportMode.Importance)
    direction = np.asarray(wi) / np.linalg.norm(wi)
    count = 100_000
    si = interaction(np.repeat(direction[:, None], count, axis=1).astype(np.float32))
    u = np.random.default_rng(9).random((3, count)).astype(np.float32) * np.float32(1.0 - 2.0**-24)
    _, weight = bsdf.sample(context, si, mi.Float(u[0]), mi.Point2f(u[1:]), True)
    weights = np.asarray(weight.x, dtype=np.float64)
    error = weights.std() / np.sqrt(count)
    assert abs(weights.mean() - 1.0) < 4.0 * error + 1e-5, f"{parameters}: {weights.mean()}"


def test_a_convex_white_object_vanishes_in_a_white_furnace(active: str, settings: Any):
    scene = {
        "type": "scene",
        "sensor": {"type": "perspective", "fov": 20.0, "to_world": camera((0.0, 0.0, 6.0))},
        "sky": {"type": "constant", "radiance": rgb(1.0)},
        "diffuse": sphere((-0.6, 0.0, 0.0), 0.5, phong(diffuse_reflectance=1.0)),
        "mirror": sphere((0.6, 0.0, 0.0), 0.5, phong(reflection=1.0)),
    }
    # Deep enough for light that goes from one to the other: what is left after 64 is below 1e-6.
    loaded = load(scene, settings("path", 16, max_depth=64), active)
    image, _ = render(loaded, 1, 64)
    # Every path carries weight 1 with multiple importance sampling of the sky: its weights sum to 1
    # in expectation only where the sky is sampled by chance, so the pixels have noise.
    assert abs(image.mean() - 1.0) < 4.0 * image.std() / np.sqrt(image.size) + 1e-4, image.mean()


def camera(origin: tuple[float, float, float]) -> Any:
    import mitsuba as mi

    return mi.ScalarTransform4f().look_at(origin=list(origin), target=[0, 0, 0], up=[0, 1, 0])


def sphere(centre: tuple[float, float, float], radius: float, bsdf: dict[str, Any]) -> Any:
    return {"type": "sphere", "center": list(centre), "radius": radius, "bsdf": bsdf}


@pytest.mark.parametrize(
    "wi", [(0.0, 0.0, 1.0), (0.5, 0.1, 0.6), (0.3, 0.2, -0.9), (0.1, 0.0, -1.0)]
)
def test_transmission_alone_bends_and_scales_as_dielectric_does(wi: tuple[float, float, float]):
    import mitsuba as mi

    glass = mi.load_dict({"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0})
    bsdf = mi.load_dict(phong(transmission=1.0, int_ior=1.5))
    ours, our_weight = samples(bsdf, wi, 1, seed=10)
    context = mi.BSDFContext()
    context.type_mask = mi.BSDFFlags.DeltaTransmission
    direction = np.asarray(wi) / np.linalg.norm(wi)
    si = interaction(direction[:, None].astype(np.float32))
    theirs, their_weight = glass.sample(context, si, 0.5, mi.Point2f(0.5), True)
    assert np.allclose(np.asarray(ours.wo), np.asarray(theirs.wo), atol=2e-7)
    assert np.allclose(np.asarray(ours.eta), np.asarray(theirs.eta), rtol=1e-6)
    # The dielectric's weight has its Fresnel factor 1 - F, which phong's constant replaces.
    cosine = abs(direction[2])
    eta = 1.5 if direction[2] > 0 else 1.0 / 1.5
    refracted = np.sqrt(1.0 - (1.0 - cosine**2) / eta**2)
    a_s = (cosine - eta * refracted) / (cosine + eta * refracted)
    a_p = (eta * cosine - refracted) / (eta * cosine + refracted)
    transmitted = 1.0 - 0.5 * (a_s**2 + a_p**2)
    assert np.allclose(np.asarray(our_weight) * transmitted, np.asarray(their_weight), rtol=1e-5)


def test_total_internal_reflection_of_transmission_weighs_nothing():
    import mitsuba as mi

    bsdf = mi.load_dict(phong(transmission=0.7, reflection=0.2, int_ior=1.5))
    record, weight = samples(bsdf, (0.9, 0.0, -0.43), 1000, seed=11)
    assert np.allclose(np.asarray(weight), 0.2), np.asarray(weight)
    assert np.all(np.asarray(record.wo.z) < 0.0)
    bsdf = mi.load_dict(phong(transmission=0.7, int_ior=1.5))
    _, weight = samples(bsdf, (0.9, 0.0, -0.43), 1000, seed=11)
    assert np.all(np.asarray(weight) == 0.0)


def test_the_back_reflects_only_under_twosided_or_with_transmission():
    import mitsuba as mi

    back = (0.3, 0.0, -0.8)
    opaque = phong(diffuse_reflectance=0.4, specular_reflectance=0.2, reflection=0.3)
    _, weight = samples(mi.load_dict(opaque), back, 1000, seed=12)
    assert np.all(np.asarray(weight) == 0.0)
    twosided = mi.load_dict({"type": "twosided", "bsdf": opaque})
    record, weight = samples(twosided, back, 1000, seed=12)
    _, front = samples(mi.load_dict(opaque), (0.3, 0.0, 0.8), 1000, seed=12)
    assert np.allclose(np.asarray(weight), np.asarray(front))
    assert np.all(np.asarray(record.wo.z)[np.asarray(weight.x) > 0.0] < 0.0)
    _, weight = samples(mi.load_dict(opaque | {"transmission": 0.1}), back, 100_000, seed=12)
    # Mirror 0.3 as it is; refraction 0.1 with radiance scaled by 1.5^2 into the thinner medium.
    assert abs(np.asarray(weight.x).mean() - (0.3 + 0.1 * 1.5**2)) < 1e-2


def test_value_and_density_agree_between_all_entry_points():
    import mitsuba as mi

    bsdf = mi.load_dict(phong(diffuse_reflectance=0.3, specular_reflectance=0.5, reflection=0.2))
    generator = np.random.default_rng(13)
    wi, wo = generator.standard_normal((2, 3, 1000))
    si = interaction((wi / np.linalg.norm(wi, axis=0)).astype(np.float32))
    direction = mi.Vector3f((wo / np.linalg.norm(wo, axis=0)).astype(np.float32))
    context = mi.BSDFContext()
    value, density = bsdf.eval_pdf(context, si, direction, True)
    assert np.array_equal(np.asarray(value), np.asarray(bsdf.eval(context, si, direction, True)))
    assert np.array_equal(np.asarray(density), np.asarray(bsdf.pdf(context, si, direction, True)))
    behind = (np.asarray(si.wi.z) <= 0.0) | (np.asarray(direction.z) <= 0.0)
    assert np.all(np.asarray(density)[behind] == 0.0)


def test_diffuse_phong_renders_what_mitsubas_diffuse_does(active: str, settings: Any):
    import mitsuba as mi

    from harness.scene import active_variant

    with active_variant("scalar_rgb"):
        box = mi.cornell_box()
    ours = dict(box)
    for name in ("white", "red", "green"):
        ours[name] = {"type": "phong", "diffuse_reflectance": box[name]["reflectance"]}
    images = [render(load(scene, settings("path", 16), active), 3, 16)[0] for scene in (box, ours)]
    # Same seed, same sampling routine: paths differ only where rounding decides.
    assert np.allclose(images[0].mean(), images[1].mean(), rtol=1e-4), [i.mean() for i in images]


@pytest.mark.parametrize(
    ("parameters", "word"),
    [
        ({"diffuse_reflectance": {"type": "checkerboard"}}, "diffuse_reflectance"),
        ({"exponent": 0.0}, "exponent"),
        ({"reflection": -0.5}, "reflection"),
        ({"int_ior": 0.0}, "int_ior"),
    ],
)
def test_a_bad_parameter_is_refused_by_name(parameters: dict[str, Any], word: str):
    import mitsuba as mi

    with pytest.raises(RuntimeError, match=word):
        mi.load_dict({"type": "phong"} | parameters)
