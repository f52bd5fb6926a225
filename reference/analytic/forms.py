"""Closed forms of light on a point: formulas of numbers alone, which know no scene.

`irradiance share` is irradiance over pi times the radiance of the light, the form factor of the
point to the light; `mean cosine` is what the model `haste` has in its place, the mean over the
points of a light of the cosine at the lit point (docs/lighting.md, equation 4).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def ball_share(radius: float, distance: float, cosine: float) -> float:
    """Irradiance share of a sphere light that lies wholly above the horizon: (R/d)^2 cos theta.

    The sphere looks like the disk that its silhouette cone cuts, and the share of a cone of half
    angle s about a direction at angle theta is sin^2(s) cos(theta), as long as no part of it is
    below the horizon.
    """
    return (radius / distance) ** 2 * cosine


def ball_mean_cosine(radius: float, distance: float, cosine: float) -> float:
    """Mean over the volume of a ball of the cosine towards it: (1 - R^2 / (5 d^2)) cos theta.

    With f(x) = |x|, the cosine at p towards a point c + u is -n . grad_p f(c + u - p), so the mean
    is that derivative of the mean of f over the ball. Outside the origin f is biharmonic
    (lap f = 2 / |x|, whose own Laplacian is 0), and the mean of such a function over a ball is
    f + R^2 / 10 lap f, here d + R^2 / (5 d). Differentiated with respect to p along n this is
    (1 - R^2 / (5 d^2)) cos theta. The ball must lie wholly above the horizon.
    """
    return (1.0 - radius**2 / (5.0 * distance**2)) * cosine


def disk_share(radius: float, height: float, blocked_sine: float = 0.0) -> float:
    """Irradiance share of a disk straight above that faces the point: R^2 / (R^2 + h^2).

    A sphere between them, on the same axis, takes the cone whose half angle has the sine
    `blocked_sine` (its radius over its distance), and with it that sine squared.
    """
    return radius**2 / (radius**2 + height**2) - blocked_sine**2


def disk_mean_cosine(radius: float, height: float, blocked_sine: float = 0.0) -> float:
    """Mean over a disk straight above of the cosine towards it, 0 where a sphere hides the disk.

    The cosine at r from the axis is h / sqrt(r^2 + h^2). Its integral 2 pi r dr from r0 to R, over
    pi R^2, is 2 h (sqrt(R^2 + h^2) - sqrt(r0^2 + h^2)) / R^2. A coaxial sphere hides the disk up to
    r0 = h tan s, s being the half angle of its cone, so that sqrt(r0^2 + h^2) = h / cos s.
    """
    hidden = height / math.sqrt(1.0 - blocked_sine**2)
    return 2.0 * height * (math.hypot(radius, height) - hidden) / radius**2


def rectangle_mean_cosine(x: tuple[float, float], y: tuple[float, float], height: float) -> float:
    """Mean of h / sqrt(x^2 + y^2 + h^2) over the rectangle x[0]..x[1], y[0]..y[1].

    It is the mean cosine of a rectangle that is parallel to the lit surface. The integral of
    1 / sqrt(x^2 + y^2 + h^2) over the rectangle from 0 to (a, b) is
    a asinh(b / sqrt(a^2 + h^2)) + b asinh(a / sqrt(b^2 + h^2)) - h atan(a b / (h sqrt(a^2 + b^2 +
    h^2))), as differentiating by a and b shows; it is odd in both, and any rectangle is four such.
    """

    def corner(a: float, b: float) -> float:
        return (
            a * math.asinh(b / math.hypot(a, height))
            + b * math.asinh(a / math.hypot(b, height))
            - height * math.atan(a * b / (height * math.sqrt(a * a + b * b + height * height)))
        )

    integral = corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
    return height * integral / ((x[1] - x[0]) * (y[1] - y[0]))


def polygon_share(point: Array, normal: Array, corners: Array) -> Array:
    """Irradiance share of polygons of uniform radiance, seen wholly above the horizon.

    Lambert's formula: 1/(2 pi) times the sum over edges of the angle that the edge subtends at the
    point, times n . Gamma, the unit normal of the plane through point and edge.

    Parameters
    ----------
    point, normal
        [3], the lit point and its unit normal.
    corners
        [n, k, 3], polygons of k corners. Counterclockwise seen from the point is positive.

    Returns
    -------
    Array
        [n].
    """
    arms = corners - point
    arms /= np.linalg.norm(arms, axis=-1, keepdims=True)
    nexts = np.roll(arms, -1, axis=1)
    planes = np.cross(arms, nexts)
    sines = np.linalg.norm(planes, axis=-1)
    angles = np.arctan2(sines, np.sum(arms * nexts, axis=-1))
    heights = planes @ normal / np.where(sines > 0.0, sines, 1.0)
    return -np.sum(angles * heights, axis=-1) / (2.0 * math.pi)


def ball_directions(
    distance: float, radius: float, axis: Array, order: int = 48, turns: int = 192
) -> tuple[Array, Array, Array]:
    """Quadrature over the directions in which a ball is seen.

    With sin psi = (R/d) sin tau, psi being the angle to the axis, everything below is smooth in
    tau: a Gauss-Legendre rule in tau and equal steps around the axis converge exponentially. A ray
    at psi runs through the ball from t1 to t2 = d cos psi -+ R cos tau, and a cone of it holds
    (t2^3 - t1^3) / 3 of the volume a steradian.

    Parameters
    ----------
    distance, radius
        Of the ball, from the point where it is seen.
    axis
        [3], unit vector towards its centre.
    order, turns
        Points of the rule in tau and around the axis.

    Returns
    -------
    directions
        [n, 3], unit vectors.
    solid_angle
        [n], weights that add up to the solid angle of the ball.
    volume_share
        [n], weights that add up to 1: the mean over the volume of a function of direction.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    tau = 0.25 * math.pi * (nodes + 1.0)
    ratio = radius / distance
    sine, cosine = ratio * np.sin(tau), np.sqrt(1.0 - (ratio * np.sin(tau)) ** 2)
    solid = weights * 0.25 * math.pi * ratio**2 * np.sin(tau) * np.cos(tau) / cosine
    solid *= 2.0 * math.pi / turns
    far, near = (distance * cosine + sign * radius * np.cos(tau) for sign in (1.0, -1.0))
    volume = solid * (far**3 - near**3) / (4.0 * math.pi * radius**3)
    angle = 2.0 * math.pi * np.arange(turns) / turns
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    ring = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    directions = cosine[:, None, None] * axis + sine[:, None, None] * ring
    return directions.reshape(-1, 3), np.repeat(solid, turns), np.repeat(volume, turns)


def fresnel(cosine: Array | float, ior: float) -> Array:
    """Unpolarised reflectance of a smooth dielectric of index `ior`, met from outside.

    Fresnel's equations; `cosine` is that of the angle of incidence, ior > 1.
    """
    incident = np.asarray(cosine, dtype=np.float64)
    transmitted = np.sqrt(1.0 - (1.0 - incident**2) / ior**2)
    perpendicular = (incident - ior * transmitted) / (incident + ior * transmitted)
    parallel = (transmitted - ior * incident) / (transmitted + ior * incident)
    return 0.5 * (perpendicular**2 + parallel**2)


def geometric(ratio: Array | float, terms: int) -> Array:
    """1 + r + r^2 + ... of `terms` terms: (1 - r^n) / (1 - r), and n where r is 1."""
    ratio = np.asarray(ratio, dtype=np.float64)
    powers = ratio[..., None] ** np.arange(terms)
    return powers.sum(axis=-1)


def slab_transmittance(ior: float, depth: int) -> float:
    """Transmittance of a glass slab at normal incidence along paths of at most `depth` segments.

    Light crosses both faces, (1 - F)^2, after 0, 2, 4 ... reflections inside, F^0 + F^2 + ...; a
    path with j pairs of reflections has 3 + 2 j segments. All of them together are
    (1 - F) / (1 + F) = 2 n / (n^2 + 1).
    """
    reflectance = float(fresnel(1.0, ior))
    pairs = max(0, (depth - 1) // 2)
    return (1.0 - reflectance) ** 2 * float(geometric(reflectance**2, pairs))


def glass_sphere_share(cosine: Array, ior: float, depth: int) -> Array:
    """Share of a uniform sky that a glass sphere sends to the eye in at most `depth` segments.

    A ray meets the sphere from inside at the angle at which it was refracted, where the
    reflectance is the F of its entry again. So F goes back at once (2 segments), (1 - F)^2 F^j
    leaves after j reflections inside (3 + j segments), and (1 - F) F^(depth - 2) is still inside:
    the rest, 1 - (1 - F) F^(depth - 2), is seen.
    """
    if depth < 2:
        return np.zeros_like(cosine)
    reflectance = fresnel(cosine, ior)
    return 1.0 - (1.0 - reflectance) * reflectance ** (depth - 2)
