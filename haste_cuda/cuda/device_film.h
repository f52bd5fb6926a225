#pragma once

#include "cuda/kernels/render_params.h"
#include "cuda/memory.h"
#include "engine/pass_folder.h"
#include "engine/schedule.h"

namespace haste::cuda {

/// The film of a pass, its faults and the counts of rays in device memory.
class DeviceFilm {
public:
    /// `size`: sums, 3 a pixel and layer. Throws CudaError.
    DeviceFilm(std::size_t size, FilmKind kind, const FixedPoint& format)
        : format_(format), faults_(1), rays_(1) {
        if (kind == FilmKind::int64) {
            sums_ = DeviceBuffer<i64>(size);
        } else {
            values_ = DeviceBuffer<float>(size);
        }
    }

    [[nodiscard]] FilmTarget target() const {
        return {format_, sums_.data(), values_.data(), faults_.data(), 0};
    }
    [[nodiscard]] RayCounts* rays() const { return rays_.data(); }

    /// Empties all of it before a pass, behind the work in `stream`.
    void clear(const Stream& stream) {
        const FilmFaults none;
        faults_.upload(std::span(&none, 1));
        sums_.clear(stream);
        values_.clear(stream);
        rays_.clear(stream);
    }

    /// The film of a pass whose work is done.
    [[nodiscard]] PassFilm download() const {
        return {sums_.download(), values_.download(), faults_.download()[0]};
    }
    [[nodiscard]] RayCounts download_rays() const { return rays_.download()[0]; }

private:
    FixedPoint format_;
    DeviceBuffer<i64> sums_;
    DeviceBuffer<float> values_;
    DeviceBuffer<FilmFaults> faults_;
    DeviceBuffer<RayCounts> rays_;
};

}  // namespace haste::cuda
