#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace haste {

/// SHA-256 (FIPS 180-4), fed piece by piece. Names cached kernels, trees and films.
class Sha256 {
public:
    using Digest = std::array<std::uint8_t, 32>;

    /// Appends the bytes to the message.
    void update(std::span<const std::byte> bytes);
    void update(std::string_view text);

    /// Appends the length in front of the text, so that "ab" + "c" and "a" + "bc" differ.
    void update_field(std::string_view text);

    /// The digest of all bytes so far. More may be appended afterwards.
    [[nodiscard]] Digest digest() const;

    /// The digest as 64 lower-case hexadecimal digits.
    [[nodiscard]] std::string hex() const;

private:
    static constexpr std::size_t block_size = 64;

    void compress(const std::byte* block);

    std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::array<std::byte, block_size> pending_{};
    std::size_t pending_size_ = 0;
    std::uint64_t message_size_ = 0;
};

/// SHA-256 of one piece of memory, as 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace haste
