#pragma once

#include "core/config.h"
#include "core/math/numeric.h"

namespace haste {

/// Three components: a point, a direction or an RGB colour.
template <class Real>
struct Vec3 {
    Real x, y, z;

    HASTE_HD constexpr Vec3& operator+=(const Vec3& b) {
        x += b.x, y += b.y, z += b.z;
        return *this;
    }
};

template <class Real>
HASTE_HD constexpr Vec3<Real> splat(Real a) {
    return {a, a, a};
}

template <class Real>
HASTE_HD constexpr Vec3<Real> operator+(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}

template <class Real>
HASTE_HD constexpr Vec3<Real> operator-(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

template <class Real>
HASTE_HD constexpr Vec3<Real> operator-(const Vec3<Real>& a) {
    return {-a.x, -a.y, -a.z};
}

template <class Real>
HASTE_HD constexpr Vec3<Real> operator*(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

template <class Real>
HASTE_HD constexpr Vec3<Real> operator*(const Vec3<Real>& a, Real s) {
    return {a.x * s, a.y * s, a.z * s};
}

template <class Real>
HASTE_HD constexpr Vec3<Real> operator*(Real s, const Vec3<Real>& a) {
    return a * s;
}

template <class Real>
HASTE_HD constexpr Real dot(const Vec3<Real>& a, const Vec3<Real>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Cross product, each component within 1.5 ulp.
template <class Real>
HASTE_HD Vec3<Real> cross(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
            difference_of_products(a.x, b.y, a.y, b.x)};
}

template <class Real>
HASTE_HD constexpr Real length_squared(const Vec3<Real>& a) {
    return dot(a, a);
}

template <class Real>
HASTE_HD Real length(const Vec3<Real>& a) {
    return square_root(dot(a, a));
}

template <class Real>
HASTE_HD Vec3<Real> normalize(const Vec3<Real>& a) {
    return a * (Real(1) / length(a));
}

template <class Real>
HASTE_HD constexpr Real max_component(const Vec3<Real>& a) {
    return maximum(a.x, maximum(a.y, a.z));
}

/// Largest absolute component: the scale that rounding errors of a point are proportional to.
template <class Real>
HASTE_HD constexpr Real max_norm(const Vec3<Real>& a) {
    return max_component(Vec3<Real>{absolute(a.x), absolute(a.y), absolute(a.z)});
}

template <class Real>
HASTE_HD constexpr bool is_zero(const Vec3<Real>& a) {
    return a.x == Real(0) && a.y == Real(0) && a.z == Real(0);
}

}  // namespace haste
