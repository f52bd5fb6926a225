"""Every closed form against an integral that shares nothing with its derivation."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate

from reference.analytic import forms

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])


def gauss(order: int, lower: float, upper: float) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(order)
    half = 0.5 * (upper - lower)
    return lower + half * (nodes + 1.0), half * weights


def ball_mean(centre: Array, radius: float, function: Callable[[Array], Array]) -> float:
    """Mean over the volume of a ball of a function of points [n, 3], by a product rule."""
    r, w_r = gauss(24, 0.0, radius)
    mu, w_mu = gauss(24, -1.0, 1.0)
    phi = 2.0 * math.pi * np.arange(64) / 64
    r, mu, phi = np.meshgrid(r, mu, phi, indexing="ij")
    side = r * np.sqrt(1.0 - mu**2)
    points = centre + np.stack([side * np.cos(phi), side * np.sin(phi), r * mu], axis=-1)
    weights = w_r[:, None, None] * w_mu[None, :, None] * r**2 * (2.0 * math.pi / 64)
    return float((weights * function(points)).sum() / (4.0 / 3.0 * math.pi * radius**3))


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.2])
@pytest.mark.parametrize(("radius", "distance"), [(0.5, 2.0), (0.3, 1.0)])
def test_the_mean_cosine_of_a_ball(radius: float, distance: float, angle: float) -> None:
    centre = distance * np.array([math.sin(angle), 0.0, math.cos(angle)])
    integral = ball_mean(centre, radius, lambda p: p[..., 2] / np.linalg.norm(p, axis=-1))
    closed = forms.ball_mean_cosine(radius, distance, math.cos(angle))
    assert closed == pytest.approx(integral, rel=1e-9), (radius, distance, angle)


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.2])
def test_the_irradiance_of_a_sphere(angle: float) -> None:
    radius, distance = 0.5, 2.0

    def integrand(phi: float, psi: float) -> float:
        height = math.cos(psi) * math.cos(angle) + math.sin(psi) * math.cos(phi) * math.sin(angle)
        return height * math.sin(psi) / math.pi

    edge = math.asin(radius / distance)
    integral, _ = integrate.dblquad(integrand, 0.0, edge, 0.0, 2.0 * math.pi)
    closed = forms.ball_share(radius, distance, math.cos(angle))
    assert closed == pytest.approx(integral, rel=1e-9), angle


@pytest.mark.parametrize("blocker", [0.0, 0.3])
def test_a_disk_behind_a_coaxial_sphere(blocker: float) -> None:
    radius, height, distance = 1.2, 3.0, 1.5

    def visible(r: float) -> bool:
        # Distance of the sphere's centre to the line from the origin to the point of the disk.
        return distance * r / math.hypot(r, height) > blocker

    def share(r: float) -> float:
        return visible(r) * 2.0 * r * height**2 / (r**2 + height**2) ** 2

    def cosine(r: float) -> float:
        return visible(r) * 2.0 * r / radius**2 * height / math.hypot(r, height)

    edge = height * math.tan(math.asin(blocker / distance))
    sine = blocker / distance
    for closed, integrand in (
        (forms.disk_share(radius, height, sine), share),
        (forms.disk_mean_cosine(radius, height, sine), cosine),
    ):
        integral, _ = integrate.quad(integrand, 0.0, radius, points=[edge], limit=200)
        assert closed == pytest.approx(integral, rel=1e-9), (integrand.__name__, blocker)


@pytest.mark.parametrize(
    ("x", "y"),
    [((-0.65, 0.65), (-0.4, 0.4)), ((0.2, 1.3), (-0.1, 0.7)), ((-2.0, -1.0), (1.0, 3.0))],
)
def test_a_parallel_rectangle(x: tuple[float, float], y: tuple[float, float]) -> None:
    height = 1.5

    def cosine(b: float, a: float) -> float:
        return height / math.sqrt(a * a + b * b + height * height)

    def share(b: float, a: float) -> float:
        return height**2 / (math.pi * (a * a + b * b + height * height) ** 2)

    mean, _ = integrate.dblquad(cosine, *x, *y)
    mean /= (x[1] - x[0]) * (y[1] - y[0])
    assert forms.rectangle_mean_cosine(x, y, height) == pytest.approx(mean, rel=1e-9), (x, y)
    irradiance, _ = integrate.dblquad(share, *x, *y)
    # Counterclockwise seen from the origin below: clockwise seen from above.
    corners = [(x[0], y[0]), (x[0], y[1]), (x[1], y[1]), (x[1], y[0])]
    polygon = np.array([[(a, b, height) for a, b in corners]])
    found = forms.polygon_share(np.zeros(3), UP, polygon)
    assert found == pytest.approx([irradiance], rel=1e-9), (x, y)
    assert forms.polygon_share(np.zeros(3), UP, polygon[:, ::-1]) == pytest.approx(-found)


def test_a_tilted_triangle_is_the_sum_of_its_parts() -> None:
    triangle = np.array([[0.3, 0.1, 0.8], [1.4, -0.6, 1.9], [0.2, 1.1, 1.2]])
    middle = triangle.mean(axis=0)
    parts = np.array([[triangle[k], triangle[(k + 1) % 3], middle] for k in range(3)])
    whole = forms.polygon_share(np.zeros(3), UP, triangle[None])[0]
    assert forms.polygon_share(np.zeros(3), UP, parts).sum() == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 30.0, 200.0])
def test_a_lobe_over_a_ball(exponent: float) -> None:
    centre, radius = np.array([0.3, 2.2, 2.0]), 0.4
    mirrored = np.array([0.0, 0.8, 0.6])
    distance = float(np.linalg.norm(centre))
    directions, solid, volume = forms.ball_directions(distance, radius, centre / distance)

    def lobe(points: Array) -> Array:
        towards = points / np.linalg.norm(points, axis=-1, keepdims=True)
        return np.maximum(towards @ mirrored, 0.0) ** exponent

    assert volume.sum() == pytest.approx(1.0, rel=1e-12)
    mean = ball_mean(centre, radius, lobe)
    assert volume @ lobe(directions) == pytest.approx(mean, rel=1e-7), exponent

    axis = centre / distance
    side = np.cross(axis, UP) / np.linalg.norm(np.cross(axis, UP))

    def integrand(phi: float, psi: float) -> float:
        ring = math.cos(phi) * side + math.sin(phi) * np.cross(axis, side)
        direction = math.cos(psi) * axis + math.sin(psi) * ring
        return max(0.0, direction @ mirrored) ** exponent * direction[2] * math.sin(psi)

    edge = math.asin(radius / distance)
    integral, _ = integrate.dblquad(integrand, 0.0, edge, 0.0, 2.0 * math.pi, epsrel=1e-7)
    closed = solid @ (lobe(directions) * directions[:, 2])
    assert closed == pytest.approx(integral, rel=1e-6), exponent
    assert solid.sum() == pytest.approx(2.0 * math.pi * (1.0 - math.cos(edge)), rel=1e-12)


@pytest.mark.parametrize("ior", [1.33, 1.5, 2.4])
def test_fresnel_at_the_angles_where_it_is_known(ior: float) -> None:
    assert forms.fresnel(1.0, ior) == pytest.approx(((ior - 1.0) / (ior + 1.0)) ** 2)
    brewster = math.cos(math.atan(ior))
    half = 0.5 * ((ior**2 - 1.0) / (ior**2 + 1.0)) ** 2
    assert forms.fresnel(brewster, ior) == pytest.approx(half)
    assert forms.fresnel(0.0, ior) == pytest.approx(1.0)


def walk(reflectance: float, depth: int, *, exits: tuple[str, ...]) -> float:
    """What leaves glass by `exits` when every path of `depth` segments is followed, branch by
    branch: the ray tree in full, on a slab or (one wall everywhere) a sphere.
    """
    total = 0.0
    rays = [("outside", 1.0, 1)]
    while rays:
        place, weight, segments = rays.pop()
        if place in exits:
            total += weight
            continue
        if place in {"front", "back", "lost"} or segments >= depth:
            continue
        through = {"outside": "down", "down": "back", "up": "front"}[place]
        returned = {"outside": "front", "down": "up", "up": "down"}[place]
        rays.append((through, weight * (1.0 - reflectance), segments + 1))
        rays.append((returned, weight * reflectance, segments + 1))
    return total


@pytest.mark.parametrize("depth", [2, 3, 4, 5, 8, 12])
def test_a_slab_is_the_sum_over_its_ray_tree(depth: int) -> None:
    reflectance = float(forms.fresnel(1.0, 2.4))
    expected = walk(reflectance, depth, exits=("back",))
    assert forms.slab_transmittance(2.4, depth) == pytest.approx(expected, rel=1e-12), depth


def test_a_deep_slab_transmits_what_the_textbooks_say() -> None:
    assert forms.slab_transmittance(1.5, 40) == pytest.approx(2 * 1.5 / (1.5**2 + 1), rel=1e-12)


@pytest.mark.parametrize("depth", [1, 2, 3, 4, 7])
def test_a_glass_sphere_is_the_sum_over_its_ray_tree(depth: int) -> None:
    cosine = 0.4
    reflectance = float(forms.fresnel(cosine, 1.5))
    expected = walk(reflectance, depth, exits=("front", "back"))
    share = forms.glass_sphere_share(np.array([cosine]), 1.5, depth)
    assert share == pytest.approx([expected], rel=1e-12), depth


def test_a_geometric_series_at_and_below_one() -> None:
    assert forms.geometric(np.array([0.5, 0.8, 1.0]), 8) == pytest.approx(
        [(1 - 0.5**8) / 0.5, (1 - 0.8**8) / 0.2, 8.0]
    )
