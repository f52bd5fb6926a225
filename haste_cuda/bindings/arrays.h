#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <initializer_list>
#include <utility>
#include <vector>

#include "accel/host_scene.h"

namespace haste {

/// An array that Python hands over, in the host's memory and without gaps.
template <class T, class... Shape>
using Array = nanobind::ndarray<const T, Shape..., nanobind::c_contig, nanobind::device::cpu>;
using Points = Array<float, nanobind::shape<-1, 3>>;
using Reals = Array<float, nanobind::ndim<1>>;
using Indices = Array<u32, nanobind::ndim<1>>;

inline Vec3f point(const Points& array, std::size_t i) {
    return {array(i, 0), array(i, 1), array(i, 2)};
}

/// A numpy array that owns `values`.
template <class T>
nanobind::object to_numpy(std::vector<T> values, std::initializer_list<std::size_t> shape) {
    auto* data = new std::vector<T>(std::move(values));
    const nanobind::capsule owner(data,
                                  [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nanobind::cast(nanobind::ndarray<nanobind::numpy, T>(data->data(), shape, owner));
}

}  // namespace haste
