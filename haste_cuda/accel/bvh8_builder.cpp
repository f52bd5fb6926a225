#include "accel/bvh8_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include "accel/sha256.h"
#include "host/stopwatch.h"

namespace haste {

namespace {

/// The heuristic's costs, Ylitie et al., section 3.1: a node against a primitive. Theirs is 0.3 for
/// a primitive; a watertight test has twice the instructions of theirs, and a node's test fewer.
constexpr float node_cost = 1.0f;
constexpr float primitive_cost = 1.2f;

/// A subtree of the binary BVH: an inner node, or the leaf of `count` records from `first` on.
struct Subtree {
    Box box;
    u32 first;
    u32 count;

    [[nodiscard]] bool is_leaf() const { return count > 0; }
    /// The second child of a tree that is one leaf.
    [[nodiscard]] bool is_nothing() const { return box.lower[0] > box.upper[0]; }
};

Subtree child_of(const Bvh2Node& node, int side) {
    return {node.box[side], node.child[side], node.count[side]};
}

Box joined(const Box& a, const Box& b) {
    Box box{};
    for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(a.lower[k], b.lower[k]);
        box.upper[k] = std::max(a.upper[k], b.upper[k]);
    }
    return box;
}

double half_area(const Box& box) {
    const double x = double(box.upper[0]) - box.lower[0];
    const double y = double(box.upper[1]) - box.lower[1];
    const double z = double(box.upper[2]) - box.lower[2];
    return x * y + y * z + z * x;
}

/// What the dynamic programme knows of a binary inner node: the least cost of turning its subtree
/// into at most i trees, i = 1 .. 7, and how.
struct Plan {
    std::array<float, bvh8_width> cost;      ///< [i]; [0] is unused
    std::array<u8, bvh8_width + 1> to_left;  ///< [i]: trees of the left child, 0: as for i - 1
    bool leaf;                               ///< as one tree it is a leaf
    u32 primitives;
};

/// A child of a wide node.
struct Child {
    Subtree subtree;
    bool leaf;  ///< all its primitives go into one leaf
};

/// Which slot each child is put into.
using Slots = std::array<u32, bvh8_width>;

/// x - y rounded down in double precision: the difference's own error decides.
double difference_down(double x, double y) {
    const double difference = x - y;
    const double back = difference - x;
    const double error = (x - (difference - back)) - (y + back);
    return error < 0 ? std::nextafter(difference, -std::numeric_limits<double>::infinity())
                     : difference;
}

double difference_up(double x, double y) { return -difference_down(y, x); }

float float_below(double x) {
    const float f = float(x);
    return double(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

/// The grid of one axis of a node, and the planes of boxes on it, which lie `plane_margin` steps
/// or more outside of the box. For the lower plane b, in exact arithmetic but for roundings that
/// are named: let x be (b - origin) / step, its difference rounded down and its division by a power
/// of two exact. Then q = floor(x - plane_margin) - plane_offset gives a plane <= b - plane_margin
/// step, where the last subtraction may err by 2^-37 at most (x is below 2^16), a nothing beside
/// the half of the margin that no traversal uses. The plane of q = 0 lies two margins below the
/// least b, so that q is not negative. Upper planes are the mirror image.
class Grid {
public:
    Grid(float lower, float upper) {
        // The exponent that spans the box with no margin, and then what the margins need.
        const double extent = difference_up(upper, lower);
        biased_ = extent > 0 ? std::clamp(std::ilogb(extent / 255.0) + 127, 1, 254) : 1;
        for (;; ++biased_) {
            if (biased_ > 254) throw std::runtime_error("the BVH's boxes exceed single precision");
            step_ = std::ldexp(1.0, biased_ - 127);
            const double below = double(plane_offset) + 2.0 * plane_margin;
            origin_ = float_below(difference_down(lower, below * step_));
            if (std::isfinite(origin_) && steps_up(upper) <= 255.0) return;
        }
    }

    [[nodiscard]] float origin() const { return origin_; }
    [[nodiscard]] u32 biased_exponent() const { return u32(biased_); }
    [[nodiscard]] u32 lower(float plane) const {
        return u32(std::floor(difference_down(plane, origin_) / step_ - double(plane_margin)) -
                   double(plane_offset));
    }
    [[nodiscard]] u32 upper(float plane) const { return u32(steps_up(plane)); }

private:
    [[nodiscard]] double steps_up(float plane) const {
        return std::ceil(difference_up(plane, origin_) / step_ + double(plane_margin)) -
               double(plane_offset);
    }

    float origin_ = 0;
    double step_ = 0;
    int biased_ = 0;
};

class Collapse {
public:
    explicit Collapse(const BuiltBvh& binary) : binary_(binary), plans_(binary.nodes.size()) {}

    BuiltBvh8 run() {
        const Stopwatch watch;
        const Bvh2Node& root = binary_.nodes[0];
        const double area = half_area(joined(root.box[0], root.box[1]));
        if (area > 0) area_unit_ = area;
        for (std::size_t i = plans_.size(); i-- > 0;) plan(u32(i));
        built_.nodes.emplace_back();
        emit(0, 0, 1);
        return finish(watch.seconds());
    }

private:
    /// The probability that a ray through the scene enters the box.
    [[nodiscard]] float relative_area(const Box& box) const {
        return float(half_area(box) / area_unit_);
    }

    [[nodiscard]] float cost(const Subtree& subtree, u32 trees) const {
        if (subtree.is_nothing()) return 0;
        if (subtree.is_leaf()) {
            return relative_area(subtree.box) * primitive_cost * float(subtree.count);
        }
        return plans_[subtree.first].cost[std::min(trees, bvh8_width - 1)];
    }

    [[nodiscard]] u32 primitives(const Subtree& subtree) const {
        return subtree.is_leaf() ? subtree.count : plans_[subtree.first].primitives;
    }

    /// Equations of section 3.1: C(n, i) from the children's, which come later in the array.
    void plan(u32 index) {
        const Bvh2Node& node = binary_.nodes[index];
        const Subtree left = child_of(node, 0);
        const Subtree right = child_of(node, 1);
        Plan& plan = plans_[index];
        plan.primitives = primitives(left) + primitives(right);
        std::array<float, bvh8_width + 1> distributed{};
        for (u32 trees = 2; trees <= bvh8_width; ++trees) {
            for (u32 k = 1; k < trees; ++k) {
                const float both = cost(left, k) + cost(right, trees - k);
                if (k == 1 || both < distributed[trees]) {
                    distributed[trees] = both;
                    plan.to_left[trees] = u8(k);
                }
            }
        }
        const float area = relative_area(joined(left.box, right.box));
        const float as_leaf = plan.primitives <= max_bvh8_leaf
                                  ? area * primitive_cost * float(plan.primitives)
                                  : std::numeric_limits<float>::infinity();
        const float as_node = distributed[bvh8_width] + area * node_cost;
        plan.leaf = as_leaf <= as_node;
        plan.cost[1] = std::min(as_leaf, as_node);
        for (u32 trees = 2; trees < bvh8_width; ++trees) {
            plan.cost[trees] = std::min(distributed[trees], plan.cost[trees - 1]);
            if (!(distributed[trees] < plan.cost[trees - 1])) plan.to_left[trees] = 0;
        }
    }

    /// The roots of the trees that a subtree becomes, at most `trees`.
    void gather(const Subtree& subtree, u32 trees, std::vector<Child>& children) const {
        if (subtree.is_nothing()) return;
        if (subtree.is_leaf()) {
            children.push_back({subtree, true});
            return;
        }
        const Plan& plan = plans_[subtree.first];
        while (trees > 1 && trees < bvh8_width && plan.to_left[trees] == 0) --trees;
        if (trees == 1) {
            children.push_back({subtree, plan.leaf});
            return;
        }
        const Bvh2Node& node = binary_.nodes[subtree.first];
        const u32 to_left = plan.to_left[trees];
        gather(child_of(node, 0), to_left, children);
        gather(child_of(node, 1), trees - to_left, children);
    }

    /// Writes the wide node `place` for the binary inner node `index`, and all below it.
    void emit(u32 index, u32 place, u32 depth) {
        if (depth > max_bvh8_depth) {
            throw std::runtime_error("the wide BVH is deeper than " +
                                     std::to_string(max_bvh8_depth));
        }
        built_.info.depth = std::max(built_.info.depth, depth);
        std::vector<Child> children;
        const Bvh2Node& binary = binary_.nodes[index];
        const u32 to_left = plans_[index].to_left[bvh8_width];
        gather(child_of(binary, 0), to_left, children);
        gather(child_of(binary, 1), bvh8_width - to_left, children);

        std::array<int, bvh8_width> in_slot;
        in_slot.fill(-1);
        const Slots slots = assign(children);
        for (std::size_t i = 0; i < children.size(); ++i) in_slot[slots[i]] = int(i);

        Bvh8Node node = with_planes(children, in_slot);
        node.offset_bits = float_bits(plane_offset);
        node.first_child = u32(built_.nodes.size());
        node.first_primitive = u32(built_.records.size());
        u32 inner = 0;
        for (u32 slot = 0; slot < bvh8_width; ++slot) {
            if (in_slot[slot] < 0) continue;
            const Child& child = children[std::size_t(in_slot[slot])];
            if (child.leaf) {
                const u32 count = add_leaf(child.subtree);
                node.primitives |= ((1u << count) - 1) << (3 * slot);
            } else {
                inner |= 1u << slot;
            }
        }
        node.frame |= inner << 24;
        built_.nodes[place] = node;
        u32 next = node.first_child;
        built_.nodes.resize(built_.nodes.size() + std::size_t(std::popcount(inner)));
        for (u32 slot = 0; slot < bvh8_width; ++slot) {
            if (inner & (1u << slot)) {
                emit(children[std::size_t(in_slot[slot])].subtree.first, next++, depth + 1);
            }
        }
    }

    /// Section 3.3: of all ways to put the children into slots, the one that places them farthest
    /// along the slots' diagonals in sum, so that a ray visits them in about the order in which it
    /// enters them. Bit a of a slot is set for the farther side of axis a.
    [[nodiscard]] static Slots assign(const std::vector<Child>& children) {
        constexpr u32 sets = 1u << bvh8_width;
        // gain[set]: the most that the first popcount(set) children win in the slots of the set.
        std::array<float, sets> gain;
        std::array<u8, sets> last;
        gain.fill(-std::numeric_limits<float>::infinity());
        gain[0] = 0;
        const std::size_t count = children.size();
        std::array<std::array<float, bvh8_width>, bvh8_width> along{};
        Box whole = children[0].subtree.box;
        for (const Child& child : children) whole = joined(whole, child.subtree.box);
        for (std::size_t i = 0; i < count; ++i) {
            const Box& box = children[i].subtree.box;
            for (u32 slot = 0; slot < bvh8_width; ++slot) {
                for (int k = 0; k < 3; ++k) {
                    const float offset =
                        (box.lower[k] - whole.lower[k]) - (whole.upper[k] - box.upper[k]);
                    along[i][slot] += slot & (1u << k) ? offset : -offset;
                }
            }
        }
        for (u32 set = 0; set < sets; ++set) {
            const auto i = std::size_t(std::popcount(set));
            if (i >= count) continue;
            for (u32 slot = 0; slot < bvh8_width; ++slot) {
                const u32 larger = set | (1u << slot);
                const float sum = gain[set] + along[i][slot];
                if (larger != set && sum > gain[larger]) {
                    gain[larger] = sum;
                    last[larger] = u8(slot);
                }
            }
        }
        u32 best = 0;
        for (u32 set = 1; set < sets; ++set) {
            if (std::size_t(std::popcount(set)) != count) continue;
            if (best == 0 || gain[set] > gain[best]) best = set;
        }
        Slots slots{};
        for (std::size_t i = count; i-- > 0;) {
            slots[i] = last[best];
            best &= ~(1u << slots[i]);
        }
        return slots;
    }

    [[nodiscard]] static Bvh8Node with_planes(const std::vector<Child>& children,
                                              const std::array<int, bvh8_width>& in_slot) {
        Bvh8Node node{};
        Box whole = children[0].subtree.box;
        for (const Child& child : children) whole = joined(whole, child.subtree.box);
        for (int k = 0; k < 3; ++k) {
            const Grid grid(whole.lower[k], whole.upper[k]);
            node.origin[k] = grid.origin();
            node.frame |= grid.biased_exponent() << (8 * k);
            for (u32 slot = 0; slot < bvh8_width; ++slot) {
                if (in_slot[slot] < 0) continue;
                const Box& box = children[std::size_t(in_slot[slot])].subtree.box;
                const u32 shift = 8 * (slot % 4);
                node.planes[0][k][slot / 4] |= grid.lower(box.lower[k]) << shift;
                node.planes[1][k][slot / 4] |= grid.upper(box.upper[k]) << shift;
            }
        }
        return node;
    }

    /// A spatial split may have put a primitive into several of the leaves that are joined here.
    u32 add_leaf(const Subtree& subtree) {
        const auto first = std::ptrdiff_t(built_.records.size());
        append_records(subtree);
        const auto begin = built_.records.begin() + first;
        std::sort(begin, built_.records.end(),
                  [](const auto& a, const auto& b) { return a.primitive < b.primitive; });
        built_.records.erase(
            std::unique(begin, built_.records.end(),
                        [](const auto& a, const auto& b) { return a.primitive == b.primitive; }),
            built_.records.end());
        return u32(std::ptrdiff_t(built_.records.size()) - first);
    }

    void append_records(const Subtree& subtree) {
        if (subtree.is_leaf()) {
            const auto first = binary_.records.begin() + std::ptrdiff_t(subtree.first);
            built_.records.insert(built_.records.end(), first,
                                  first + std::ptrdiff_t(subtree.count));
            return;
        }
        const Bvh2Node& node = binary_.nodes[subtree.first];
        append_records(child_of(node, 0));
        append_records(child_of(node, 1));
    }

    BuiltBvh8 finish(double seconds) {
        Sha256 hash;
        hash.update(std::as_bytes(std::span(built_.nodes)));
        for (const PrimitiveRecord<float>& r : built_.records) {
            hash.update(std::as_bytes(std::span(&r.primitive, 1)));
        }
        built_.info.sha256 = hash.hex();
        built_.info.build_seconds = binary_.info.build_seconds + seconds;
        built_.info.nodes = built_.nodes.size();
        built_.info.records = built_.records.size();
        built_.info.bytes = built_.nodes.size() * sizeof(Bvh8Node) +
                            built_.records.size() * sizeof(PrimitiveRecord<float>);
        return std::move(built_);
    }

    const BuiltBvh& binary_;
    std::vector<Plan> plans_;
    double area_unit_ = 1;
    BuiltBvh8 built_;
};

}  // namespace

BuiltBvh8 build_bvh8(const BuiltBvh& binary) { return Collapse(binary).run(); }

}  // namespace haste
