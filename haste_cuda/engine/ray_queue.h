#pragma once

#include <span>

#include "core/engine/admission.h"
#include "core/sampling/sample_range.h"
#include "engine/schedule.h"
#include "host/large_array.h"

namespace haste {

/// The paper's queue of pending rays, section 4.2, bounded and topped up with camera rays: all rays
/// are treated the same, whatever they are for.
class RayQueue {
public:
    /// At most the schedule's bytes of rays wait; see `Admission`.
    RayQueue(const Camera<float>& camera, const SampleRange& range, const RayTree& tree,
             const Schedule& schedule);

    /// Makes room for so many rays, as far as the schedule's bytes allow, before they come.
    void reserve(u64 rays);

    /// Fills the front of `packet`, which has room for the schedule's packet. Returns how many rays
    /// there are; 0 means that all is done, once the children of earlier packets were pushed.
    u64 pop_packet(std::span<Ray<float>> packet);

    void push(std::span<const Ray<float>> rays);

    [[nodiscard]] u64 peak_bytes() const { return peak_ * sizeof(Ray<float>); }

private:
    void grow(u64 size);
    /// Copies `count` rays from the ring, beginning with the one at `place` from its front.
    void copy_out(u64 place, u64 count, Ray<float>* target) const;
    void make_camera_rays(std::span<Ray<float>> rays);

    Camera<float> camera_;
    SampleRange range_;
    Admission admission_;
    u64 capacity_;
    QueueOrder order_;
    u64 unborn_;
    u64 next_camera_ray_ = 0;
    u64 peak_ = 0;
    // A ring: rays_[(front_ + i) % room_] for i < size_.
    LargeArray<Ray<float>> rays_;
    u64 room_ = 0;
    u64 front_ = 0;
    u64 size_ = 0;
};

}  // namespace haste
