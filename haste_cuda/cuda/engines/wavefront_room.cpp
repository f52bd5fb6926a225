#include "cuda/engines/wavefront_room.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "cuda/kernels/wavefront_params.h"

namespace haste::cuda {

WavefrontRoom WavefrontRoom::fit(const RayTree& tree, u64 bytes, u64 packet, u64 lanes,
                                 u64 most_shadow_rays) {
    constexpr u64 ray = sizeof(Ray<float>);
    const u64 each = WavefrontParams::packet_ray_bytes(most_shadow_rays);
    const u64 need = tree.lifo_need();
    if (bytes < need * ray + each) {
        throw std::invalid_argument("queue_bytes must be at least " +
                                    std::to_string(need * ray + each) +
                                    " for the rays of one sample and the hit and shadow rays of "
                                    "one ray, not " +
                                    std::to_string(bytes));
    }
    // The packet that a lane of so many bytes can have, 0 if none.
    const auto packet_within = [&](u64 own) -> u64 {
        if (own < need * ray + each) return 0;
        constexpr u64 most_shadows = u64(0xf0000000u);  // as a warp may count beyond the last
        return std::min({packet, std::max<u64>(own / 2 / each, 1), (own - need * ray) / each,
                         most_shadows / std::max<u64>(most_shadow_rays, 1)});
    };
    const u64 size = packet_within(bytes);
    while (packet_within(bytes / lanes) < size) --lanes;
    constexpr u64 most_waiting = u64(1) << 30;  // places are counted in 32 bits, a turn too far
    // More than the packets can grow to would never be used.
    const u64 queue =
        std::min({most_waiting, (bytes / lanes - size * each) / ray, 2 * need * size});
    return {lanes, size, queue};
}

}  // namespace haste::cuda
