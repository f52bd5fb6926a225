#pragma once

#include "core/engine/ray_tree.h"

namespace haste {

/// What the next packet is made of.
struct PacketPlan {
    u64 pending;  ///< rays taken from the queue
    u64 born;     ///< camera rays made for it
    bool lifo;    ///< the pending ones are the queue's newest, whatever its order

    HASTE_HD u64 size() const { return pending + born; }
};

/// The admission rule of a bounded queue of rays: it never holds more than `capacity` rays and
/// always comes to an end.
///
/// Below a mark M, packets are taken in the queue's own order, as large as the setting says and as
/// still leaves at most M rays if every ray of the packet spawns all the children it can. Where
/// that leaves fewer rays than a drain packet has, and above M, where no camera ray is admitted,
/// packets are the q newest rays.
///
/// Why that is bounded. While the queue is over M, only such drain packets run. Each leaves a batch
/// of at most q f children (f children a ray) on top of what was there. A batch that is not on top
/// has lost q rays or more to the packet whose children lie on it, and so holds at most q (f - 1);
/// and as a packet takes the newest rays, the youngest generation found in a batch rises from each
/// batch to the next. With G generations there are at most G - 1 batches, on at most M older rays:
/// M + q ((G - 1)(f - 1) + 1) rays in all. M is set so that this is the capacity; q = 1 needs room
/// for one sample's depth-first walk, without which the queue is refused.
class Admission {
public:
    /// Requires capacity >= tree.lifo_need() and packet >= 1.
    HASTE_HD Admission(const RayTree& tree, u64 capacity, u64 packet)
        : children_(tree.children), packet_(packet) {
        const u64 need = tree.lifo_need();
        // Half of the room is for draining, so that a drain's packets are not needlessly small.
        drain_ = least(packet, capacity / (2 * need));
        if (drain_ == 0) drain_ = 1;
        mark_ = capacity - drain_ * need;
    }

    /// The next packet when `pending` rays wait and `unborn` camera rays are still to be made.
    /// Empty only when both are 0.
    HASTE_HD PacketPlan next(u64 pending, u64 unborn) const {
        if (pending > mark_) return {least(drain_, pending), 0, true};
        const u64 room = mark_ - pending;
        PacketPlan plan{least(packet_, pending), 0, false};
        if (children_ > 1) plan.pending = least(plan.pending, room / (children_ - 1));
        plan.born = least(least(packet_ - plan.pending, unborn),
                          (room - plan.pending * (children_ - 1)) / children_);
        // A packet that left pending rays behind has no room for camera rays.
        if (plan.size() >= least(drain_, pending + unborn)) return plan;
        plan.pending = least(drain_, pending);
        plan.born = least(drain_ - plan.pending, unborn);
        plan.lifo = true;
        return plan;
    }

    /// M: above it no camera ray is admitted.
    [[nodiscard]] HASTE_HD u64 mark() const { return mark_; }

private:
    HASTE_HD static u64 least(u64 a, u64 b) { return a < b ? a : b; }

    u64 children_;
    u64 packet_;
    u64 drain_;
    u64 mark_;
};

}  // namespace haste
