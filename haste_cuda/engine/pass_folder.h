#pragma once

#include <memory>

#include "core/film/film_view.h"
#include "engine/render_output.h"

namespace haste {

/// A pass's sums, 3 a pixel, layer after layer: of integers, or of floats.
struct PassFilm {
    std::vector<i64> sums;
    std::vector<float> values;
    FilmFaults faults;
};

/// Folds the passes of a render, in order and in double precision, whatever engine filled them.
class PassFolder {
public:
    /// `weights`: of the film's layers, equation 8; {1} for the flat sum of equation 9.
    PassFolder(const FixedPoint& format, u32 width, u32 height, std::vector<double> weights = {1});
    ~PassFolder();
    /// Throws FilmOverflow.
    void fold(const PassFilm& film);
    /// Mean over `samples`, and the hash of all passes.
    void finish(u32 samples, RenderOutput& output);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haste
