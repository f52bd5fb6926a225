"""The scattering of `path`."""

from __future__ import annotations

import numpy as np
import pytest
from haste_cuda._core import testing

import haste_cuda

WHITE = (1.0, 1.0, 1.0)
MATERIALS = {
    "diffuse": {"diffuse": (0.7, 0.5, 0.2)},
    "glossy": {"diffuse": (0.3, 0.2, 0.1), "specular": (0.5, 0.5, 0.6), "exponent": 30},
    "sharp": {"specular": (0.9, 0.9, 0.9), "exponent": 5000},
    "mirror": {"diffuse": (0.4, 0.4, 0.4), "reflection": 0.5},
    "tinted glass": {
        "diffuse": (0.1, 0.1, 0.1),
        "reflection": 0.2,
        "transmission": 0.6,
        "ior": 1.5,
    },
    "glass": {"kind": "dielectric", "ior": 1.5},
}
VIEWS = [
    (0.0, 0.0, 1.0),
    (0.6, 0.0, 0.8),
    (0.0, -0.98, np.sqrt(1 - 0.98**2)),
    (0.3, 0.4, -np.sqrt(0.75)),
]


def material(name: str) -> haste_cuda.Material:
    return haste_cuda.Material(**MATERIALS[name])


def uniforms(count: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((count, 3), np.float32)


def sphere_grid(rings: int = 4000, sectors: int = 96) -> tuple[np.ndarray, float]:
    """Midpoints of equal-area cells on the upper hemisphere, and a cell's solid angle.

    Around, the midpoint rule converges exponentially; along z its relative error for cos^n is
    n^2 / (24 rings^2): under 3e-6 for n = 30.
    """
    z = (np.arange(rings) + 0.5) / rings
    phi = (np.arange(sectors) + 0.5) * 2 * np.pi / sectors
    z, phi = np.meshgrid(z, phi, indexing="ij")
    r = np.sqrt(1 - z**2)
    points = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1).reshape(-1, 3)
    return points.astype(np.float32), 2 * np.pi / len(points)


@pytest.mark.parametrize("name", ["diffuse", "glossy", "mirror"])
@pytest.mark.parametrize("view", VIEWS[:3])
def test_samples_reflect_as_much_as_the_integral_of_the_lobes(
    name: str, view: tuple[float, float, float]
) -> None:
    weights, delta = testing.bsdf_sample(material(name), view, uniforms(400_000, 1))[1::2]
    smooth = weights.astype(np.float64) * (delta == 0)[:, None]
    points, cell = sphere_grid()
    integral = (
        testing.bsdf_evaluate(material(name), view, points)[0].astype(np.float64).sum(0) * cell
    )
    mean, error = smooth.mean(0), smooth.std(0) / np.sqrt(len(smooth))
    assert (np.abs(mean - integral) <= 4 * error + 1e-5 * integral).all(), (
        f"{name} from {view}: sampled {mean}, integrated {integral}, error {error}"
    )


@pytest.mark.parametrize("name", ["diffuse", "glossy"])
@pytest.mark.parametrize("view", VIEWS[:3])
def test_densities_integrate_to_the_share_of_samples_above_the_surface(
    name: str, view: tuple[float, float, float]
) -> None:
    _, _, pdf, _ = testing.bsdf_sample(material(name), view, uniforms(200_000, 2))
    above = (pdf > 0).mean()
    points, cell = sphere_grid()
    integral = (
        testing.bsdf_evaluate(material(name), view, points)[1].astype(np.float64).sum() * cell
    )
    error = np.sqrt(max(above * (1 - above), 1e-6) / len(pdf))
    assert abs(above - integral) <= 4 * error + 1e-5, (
        f"{name} from {view}: {above} against {integral}"
    )


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("view", VIEWS)
def test_no_surface_reflects_more_than_arrives(name: str, view: tuple[float, float, float]) -> None:
    weights = testing.bsdf_sample(material(name), view, uniforms(200_000, 3))[1].astype(np.float64)
    if view[2] < 0 and "glass" in name:
        weights /= 1.5**2  # radiance that leaves glass spreads: eta^2 is geometry, not energy
    mean, error = weights.mean(0), weights.std(0) / np.sqrt(len(weights))
    assert (mean <= 1 + 4 * error + 1e-6).all(), f"{name} from {view}: {mean}"


@pytest.mark.parametrize("view", VIEWS)
def test_a_dielectric_passes_on_all_energy(view: tuple[float, float, float]) -> None:
    directions, weights, _, delta = testing.bsdf_sample(
        material("glass"), view, uniforms(100_000, 4)
    )
    assert delta.all()
    through = directions[:, 2] * view[2] < 0
    eta_squared = 1.5**2 if view[2] < 0 else 1.5**-2
    # Every sample carries weight 1, scaled by the index squared where it crosses.
    assert np.allclose(weights[~through], 1, rtol=1e-6)
    assert np.allclose(weights[through], eta_squared, rtol=1e-6), f"view {view}"


def test_refraction_obeys_snell() -> None:
    view = (0.6, 0.0, 0.8)
    directions, _, _, _ = testing.bsdf_sample(material("glass"), view, uniforms(1000, 5))
    through = directions[directions[:, 2] < 0]
    assert np.allclose(through[:, 0], -0.6 / 1.5, atol=2e-7) and len(through) > 500


def test_opaque_surfaces_are_black_from_behind_unless_twosided() -> None:
    behind = (0.0, 0.0, -1.0)
    assert (testing.bsdf_sample(material("glossy"), behind, uniforms(1000, 6))[1] == 0).all()
    twosided = haste_cuda.Material(**MATERIALS["glossy"], twosided=True)
    directions, weights, _, _ = testing.bsdf_sample(twosided, behind, uniforms(1000, 6))
    assert weights.mean() > 0.1 and (directions[weights.sum(-1) > 0][:, 2] < 0).all()
