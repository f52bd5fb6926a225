#include "engine/pass_folder.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "accel/sha256.h"

namespace haste {

struct PassFolder::State {
    FixedPoint format;
    u32 width, height;
    std::vector<double> weights;
    std::vector<double> sums;
    u64 non_finite = 0;
    bool integers = true;
    Sha256 hash;
};

PassFolder::PassFolder(const FixedPoint& format, u32 width, u32 height, std::vector<double> weights)
    : state_(std::make_unique<State>(State{format,
                                           width,
                                           height,
                                           std::move(weights),
                                           std::vector<double>(3 * std::size_t(width) * height),
                                           0,
                                           true,
                                           {}})) {
    state_->hash.update(std::as_bytes(std::span(&state_->format.exponent, 1)));
}

PassFolder::~PassFolder() = default;

void PassFolder::fold(const PassFilm& film) {
    u32 pixel = film.faults.overflow_pixel;
    // An overflow that no add of the GPU has checked for shows as a negative sum.
    const u64 pixels = u64(state_->width) * state_->height;
    for (std::size_t i = 0; i < film.sums.size(); ++i) {
        if (film.sums[i] < 0) pixel = std::min(pixel, u32(i / 3 % pixels));
    }
    if (pixel != FilmFaults{}.overflow_pixel) {
        throw FilmOverflow("the film overflows at pixel (" + std::to_string(pixel % state_->width) +
                           ", " + std::to_string(pixel / state_->width) +
                           "): its sum left the range of 2^" +
                           std::to_string(state_->format.exponent + 63));
    }
    state_->non_finite += film.faults.non_finite;
    state_->integers = film.values.empty();
    state_->hash.update(std::as_bytes(std::span(film.sums)));
    const std::size_t size = state_->sums.size();
    for (std::size_t layer = 0; layer < state_->weights.size(); ++layer) {
        const double weight = state_->weights[layer];
        for (std::size_t i = 0; i < size; ++i) {
            const double value = state_->integers ? std::ldexp(double(film.sums[layer * size + i]),
                                                               state_->format.exponent)
                                                  : double(film.values[layer * size + i]);
            state_->sums[i] += weight * value;
        }
    }
}

void PassFolder::finish(u32 samples, RenderOutput& output) {
    output.mean = std::move(state_->sums);
    for (double& value : output.mean) value /= samples;
    if (state_->integers) output.film_sha256 = state_->hash.hex();
    output.non_finite = state_->non_finite;
}

}  // namespace haste
