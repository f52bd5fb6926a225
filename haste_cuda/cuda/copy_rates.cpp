#include "cuda/copy_rates.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "cuda/device.h"
#include "cuda/memory.h"
#include "host/stopwatch.h"

namespace haste::cuda {

namespace {

using Bytes = std::byte;

/// The most bytes a second that a copy reached.
template <class Copy>
double best_rate(double bytes, int repeats, Copy&& copy) {
    double best = 0;
    for (int i = 0; i < repeats; ++i) {
        const Stopwatch watch;
        copy();
        best = std::max(best, bytes / watch.seconds());
    }
    return best;
}

}  // namespace

CopyRates measure_copies(std::size_t bytes, int repeats) {
    if (bytes == 0 || repeats < 1) throw std::invalid_argument("there is nothing to copy");
    const Device device;
    device.make_current();
    Stream first;
    Stream second;
    DeviceBuffer<Bytes> up(bytes);
    DeviceBuffer<Bytes> down(bytes);
    const PinnedBuffer<Bytes> pinned_up(bytes);
    const PinnedBuffer<Bytes> pinned_down(bytes);
    std::vector<Bytes> pageable(bytes);
    const double size = double(bytes);
    up.clear(first);
    down.clear(first);
    first.synchronize();
    CopyRates rates;
    rates.pinned_up = best_rate(size, repeats, [&] {
        up.upload(pinned_up.front(bytes), first);
        first.synchronize();
    });
    rates.pinned_down = best_rate(size, repeats, [&] {
        down.download(pinned_down.front(bytes), first);
        first.synchronize();
    });
    rates.pinned_both = best_rate(size, repeats, [&] {
        up.upload(pinned_up.front(bytes), first);
        down.download(pinned_down.front(bytes), second);
        first.synchronize();
        second.synchronize();
    });
    rates.pageable_up = best_rate(size, repeats, [&] { up.upload(pageable); });
    rates.pageable_down =
        best_rate(size, repeats, [&] { down.download(std::span<Bytes>(pageable)); });
    rates.device = best_rate(2 * size, repeats, [&] {
        down.copy_from(up, first);
        first.synchronize();
    });
    return rates;
}

}  // namespace haste::cuda
