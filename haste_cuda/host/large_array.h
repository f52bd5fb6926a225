#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

namespace haste {

/// An array in ordinary memory that may be large, contents undefined.
///
/// The C library takes memory for a large array afresh from the system, whose pages are made when
/// they are first written. With usual pages that takes several times as long as what is written
/// (docs/packets.md, Fresh memory).
template <class T>
class LargeArray {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>,
                  "nothing is constructed in it");

public:
    /// From so many bytes on an array begins at a page of this size, and ends with one.
    static constexpr std::size_t large_bytes = std::size_t(2) << 20;

    LargeArray() = default;

    /// Room for `size` elements. Throws std::bad_alloc.
    explicit LargeArray(std::size_t size) {
        constexpr std::size_t page = large_bytes;
        if (size == 0) return;
        if (size > (std::size_t(-1) - page) / sizeof(T)) throw std::bad_alloc();
        const std::size_t bytes = size * sizeof(T);
        const std::size_t step = bytes < page ? std::max(alignof(T), alignof(void*)) : page;
        const std::size_t whole = (bytes + step - 1) / step * step;
        data_.reset(static_cast<T*>(std::aligned_alloc(step, whole)));
        if (!data_) throw std::bad_alloc();
        // Refused where the system has no large pages: then they are those that it has.
        if (step == page) (void)madvise(data_.get(), whole, MADV_HUGEPAGE);
    }

    /// Has the system make the pages of the first `count` elements now: who writes them later need
    /// not wait for that. Their contents stay undefined.
    void make_pages(std::size_t count) {
        constexpr std::size_t least_page = 4096;
        auto* const bytes = reinterpret_cast<volatile std::byte*>(data_.get());
        for (std::size_t i = 0; i < count * sizeof(T); i += least_page) bytes[i] = std::byte{0};
    }

    [[nodiscard]] T* data() const { return data_.get(); }
    [[nodiscard]] std::span<T> front(std::size_t count) const { return {data_.get(), count}; }

private:
    struct Free {
        void operator()(T* memory) const { std::free(memory); }
    };

    std::unique_ptr<T[], Free> data_;
};

}  // namespace haste
