"""Whether a ray in single precision meets a closed triangle: decided exactly.

A ray o + t d, t > 0, meets the triangle (a, b, c) if the volumes

    d . ((a - o) x (b - o)),  d . ((b - o) x (c - o)),  d . ((c - o) x (a - o))

do not differ in sign and are not all zero, and if the plane is met at a positive t. Triangles that
are seen edge-on, and those without an area, are met by no ray.

The sign of such a determinant is taken from double precision where its error bound allows; else
from pairs of doubles, whose sums and products carry their own rounding error along (Dekker 1971;
Knuth 1981, section 4.2.2; the plan of Shewchuk 1997); and from rational numbers where these cannot
decide either.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Signs = NDArray[np.int8]
Booleans = NDArray[np.bool_]

DOUBLE_BOUND = 9.0 * 2.0**-53
"""Error of a determinant in double precision over its permanent: two roundings for two differences
of coordinates, five for products and sums (Higham 2002, lemma 3.1), and room for those of the
permanent."""

PAIR_BOUND = 2.0**-96
"""The same of pairs: operations are off by less than 2^-101 (Joldes, Muller and Popescu 2017)."""

SPLITTER = 2.0**27 + 1.0


@dataclass(frozen=True, slots=True)
class Pair:
    """Numbers as unevaluated sums high + low."""

    high: Floats
    low: Floats

    def __getitem__(self, place: object) -> "Pair":
        return Pair(self.high[place], self.low[place])

    def __add__(self, other: "Pair") -> "Pair":
        high, low = _two_sum(self.high, other.high)
        more, least = _two_sum(self.low, other.low)
        return _fast_two_sum(*_plus(_fast_two_sum(high, low + more), least))

    def __sub__(self, other: "Pair") -> "Pair":
        return self + Pair(-other.high, -other.low)

    def __mul__(self, other: "Pair") -> "Pair":
        high, low = _two_product(self.high, other.high)
        return _fast_two_sum(high, low + (self.high * other.low + self.low * other.high))


def _plus(pair: Pair, least: Floats) -> tuple[Floats, Floats]:
    return pair.high, pair.low + least


def _two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """The rounded sum, and what it lacks (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _fast_two_sum(a: Floats, b: Floats) -> Pair:
    """The same where |a| >= |b| (Dekker)."""
    total = a + b
    return Pair(total, b - (total - a))


def _halves(a: Floats) -> tuple[Floats, Floats]:
    """The upper and the lower 26 bits (Veltkamp)."""
    scaled = SPLITTER * a
    upper = scaled - (scaled - a)
    return upper, a - upper


def _two_product(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """The rounded product, and what it lacks (Dekker)."""
    product = a * b
    a1, a0 = _halves(a)
    b1, b0 = _halves(b)
    return product, a0 * b0 - (((product - a1 * b1) - a0 * b1) - a1 * b0)


def difference(a: Floats, b: Floats) -> Pair:
    """Subtract without rounding."""
    return Pair(*_two_sum(a, -b))


def determinant_sign(a: Pair, b: Pair, c: Pair) -> Signs:
    """Sign of the determinant of three vectors, [3, N] each: -1, 0 or 1, never wrong.

    The components are those of `difference`, of numbers that single precision can hold.
    """
    value, permanent = _in_doubles(a.high, b.high, c.high)
    sign = np.sign(value).astype(np.int8)
    open_ = np.flatnonzero(np.abs(value) <= DOUBLE_BOUND * permanent)
    if len(open_):
        sign[open_] = _sign_of_pairs(
            a[:, open_], b[:, open_], c[:, open_], PAIR_BOUND * permanent[open_]
        )
    return sign


def _in_doubles(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """The determinant, and the sum of the absolute values of its products."""
    value = np.zeros(a.shape[1])
    permanent = np.zeros(a.shape[1])
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        one, other = a[j] * b[k], a[k] * b[j]
        value += c[i] * (one - other)
        permanent += np.abs(c[i]) * (np.abs(one) + np.abs(other))
    return value, permanent


def _sign_of_pairs(a: Pair, b: Pair, c: Pair, bound: Floats) -> Signs:
    value = None
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        part = c[i] * (a[j] * b[k] - a[k] * b[j])
        value = part if value is None else value + part
    sign = np.sign(value.high).astype(np.int8)
    for place in np.flatnonzero(np.abs(value.high) <= bound):
        sign[place] = _sign_of_fractions(a[:, place], b[:, place], c[:, place])
    return sign


def _sign_of_fractions(a: Pair, b: Pair, c: Pair) -> int:
    x, y, z = (
        [Fraction(float(h)) + Fraction(float(low)) for h, low in zip(p.high, p.low, strict=True)]
        for p in (a, b, c)
    )
    value = sum(z[i] * (x[j] * y[k] - x[k] * y[j]) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)))
    return (value > 0) - (value < 0)


def meets(corners: Singles, origins: Singles, directions: Singles) -> Booleans:
    """Whether each ray meets its closed triangle at a positive distance.

    Parameters
    ----------
    corners
        float32 [N, 3, 3], triangle, corner, coordinate.
    origins, directions
        float32 [N, 3].

    Returns
    -------
    bool [N]. Inputs must be finite, and no product of three may leave the range of doubles, which
    those of single precision cannot.
    """
    # One coordinate after another: what is worked on then lies side by side.
    start = np.ascontiguousarray(origins.T, np.float64)
    a, b, c = (
        difference(np.ascontiguousarray(corners[:, i].T, np.float64), start) for i in range(3)
    )
    towards = Pair(np.ascontiguousarray(directions.T, np.float64), np.zeros_like(start))
    edges = np.stack([determinant_sign(p, q, towards) for p, q in ((a, b), (b, c), (c, a))])
    least, most = edges.min(axis=0), edges.max(axis=0)
    met = np.flatnonzero(((least >= 0) & (most > 0)) | ((most <= 0) & (least < 0)))
    # The plane is at (a . (b x c)) / (sum of the volumes), whose sign is that of each.
    ahead = determinant_sign(a[:, met], b[:, met], c[:, met]) == np.sign(edges[:, met].sum(axis=0))
    result = np.zeros(len(origins), bool)
    result[met[ahead]] = True
    return result
