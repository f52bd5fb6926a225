#include "engine/ray_queue.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

namespace haste {

namespace {

/// One core moves a few gigabytes a second, far less than the memory or a GPU's bus can.
void copy_rays(const Ray<float>* source, u64 count, Ray<float>* target) {
    constexpr u64 rays_per_task = 4096;
    tbb::parallel_for(tbb::blocked_range<u64>(0, count, rays_per_task),
                      [&](const tbb::blocked_range<u64>& part) {
                          std::copy_n(source + part.begin(), part.size(), target + part.begin());
                      });
}

}  // namespace

RayQueue::RayQueue(const Camera<float>& camera, const SampleRange& range, const RayTree& tree,
                   const Schedule& schedule)
    : camera_(camera),
      range_(range),
      admission_(tree, schedule.queue_bytes / sizeof(Ray<float>), schedule.packet),
      capacity_(schedule.queue_bytes / sizeof(Ray<float>)),
      order_(schedule.order),
      unborn_(range.count(camera)) {}

void RayQueue::reserve(u64 rays) {
    if (std::min(rays, capacity_) > room_) grow(rays);
    rays_.make_pages(room_);
}

u64 RayQueue::pop_packet(std::span<Ray<float>> packet) {
    const PacketPlan plan = admission_.next(size_, unborn_);
    const bool newest = plan.lifo || order_ == QueueOrder::lifo;
    copy_out(newest ? size_ - plan.pending : 0, plan.pending, packet.data());
    if (!newest) front_ = room_ == 0 ? 0 : (front_ + plan.pending) % room_;
    size_ -= plan.pending;
    make_camera_rays(packet.subspan(plan.pending, plan.born));
    return plan.size();
}

void RayQueue::push(std::span<const Ray<float>> rays) {
    if (rays.size() > capacity_ - size_) {
        throw std::logic_error("a packet spawned more rays than its model's tree can have");
    }
    if (size_ + rays.size() > room_) grow(size_ + rays.size());
    if (rays.empty()) return;
    const u64 back = (front_ + size_) % room_;
    const u64 first = std::min<u64>(rays.size(), room_ - back);
    copy_rays(rays.data(), first, rays_.data() + back);
    copy_rays(rays.data() + first, rays.size() - first, rays_.data());
    size_ += rays.size();
    peak_ = std::max(peak_, size_);
}

void RayQueue::grow(u64 size) {
    constexpr u64 smallest = 1024;
    const u64 room = std::min(capacity_, std::max({smallest, size, 2 * room_}));
    LargeArray<Ray<float>> rays(room);
    copy_out(0, size_, rays.data());
    rays_ = std::move(rays);
    room_ = room;
    front_ = 0;
}

void RayQueue::copy_out(u64 place, u64 count, Ray<float>* target) const {
    if (count == 0) return;
    const u64 begin = (front_ + place) % room_;
    const u64 first = std::min(count, room_ - begin);
    copy_rays(rays_.data() + begin, first, target);
    copy_rays(rays_.data(), count - first, target + first);
}

void RayQueue::make_camera_rays(std::span<Ray<float>> rays) {
    constexpr std::size_t rays_per_task = 1024;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), rays_per_task),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          for (std::size_t i = part.begin(); i < part.end(); ++i) {
                              rays[i] = range_.ray(camera_, next_camera_ray_ + i);
                          }
                      });
    next_camera_ray_ += rays.size();
    unborn_ -= rays.size();
}

}  // namespace haste
