#pragma once

#include "core/engine/trace_out.h"

namespace haste {

/// The rays of one sample that wait, newest last.
template <class Real>
struct RayStack {
    Ray<Real>* rays;
    u32 depth = 0;

    HASTE_HD void push(const Ray<Real>& ray) { rays[depth++] = ray; }
    HASTE_HD Ray<Real> pop() { return rays[--depth]; }
};

/// All rays of one sample, children before siblings, in memory that has room for as many rays as
/// can wait at once.
template <bool Count, class Model, class I, class Real, class Sum>
HASTE_HD void trace_sample(const Model& model, const I& intersector, const FixedPoint& format,
                           const Ray<Real>& camera, Ray<Real>* memory, Sum& sum,
                           RayCounts& counts) {
    TraceOut<Count, Real, I, Sum, RayStack<Real>> out{intersector, format, sum, counts, {memory}};
    RayStack<Real>& stack = out.children;
    stack.push(camera);
    while (stack.depth > 0) {
        const Ray<Real> ray = stack.pop();
        out.trace(model, ray);
    }
}

}  // namespace haste
