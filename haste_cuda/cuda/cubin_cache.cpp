#include "cuda/cubin_cache.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>
#include <vector>

#include "accel/sha256.h"
#include "host/stopwatch.h"

namespace haste::cuda {

namespace fs = std::filesystem;

namespace {

/// Changes when the layout of a cache file changes.
constexpr std::string_view format = "haste cubin 1";

std::string read_file(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream contents;
    contents << stream.rdbuf();
    return stream ? std::move(contents).str() : std::string();
}

/// Every header below the directory, in an order that does not depend on the file system.
std::vector<fs::path> headers_below(const fs::path& root) {
    std::vector<fs::path> headers;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
        const fs::path extension = entry.path().extension();
        if ((extension == ".h" || extension == ".cuh") && entry.is_regular_file()) {
            headers.push_back(entry.path());
        }
    }
    std::ranges::sort(headers);
    return headers;
}

std::string field(std::string_view text) {
    const std::uint64_t size = text.size();
    std::string bytes(reinterpret_cast<const char*>(&size), sizeof size);
    return bytes += text;
}

/// Takes a field off the front of `bytes`; nothing if there is no whole one.
std::optional<std::string_view> take_field(std::string_view& bytes) {
    std::uint64_t size = 0;
    if (bytes.size() < sizeof size) {
        return std::nullopt;
    }
    std::memcpy(&size, bytes.data(), sizeof size);
    bytes.remove_prefix(sizeof size);
    if (size > bytes.size()) {
        return std::nullopt;
    }
    const std::string_view text = bytes.substr(0, size);
    bytes.remove_prefix(size);
    return text;
}

std::string digest_of(std::string_view text) { return sha256_hex(std::as_bytes(std::span(text))); }

/// A name that no other writer uses at the same time, be it a thread, a process or, on a shared
/// file system, another machine.
std::string temporary_name(const std::string& key) {
    static std::atomic<unsigned> counter{0};
    const auto now = std::chrono::system_clock::now().time_since_epoch().count();
    return key + "." + std::to_string(getpid()) + "." + std::to_string(counter++) + "." +
           std::to_string(now) + ".tmp";
}

}  // namespace

CubinCache CubinCache::standard() {
    const auto variable = [](const char* name) -> std::optional<fs::path> {
        const char* value = std::getenv(name);
        return value && *value ? std::optional<fs::path>(value) : std::nullopt;
    };
    if (const auto cache = variable("HASTE_CACHE")) {
        return CubinCache(*cache / "cubin");
    }
    if (const auto cache = variable("XDG_CACHE_HOME")) {
        return CubinCache(*cache / "haste" / "cubin");
    }
    if (const auto home = variable("HOME")) {
        return CubinCache(*home / ".cache" / "haste" / "cubin");
    }
    throw std::runtime_error(
        "no place for compiled kernels: none of HASTE_CACHE, XDG_CACHE_HOME and HOME is set");
}

fs::path CubinCache::file(const std::string& key) const { return directory_ / (key + ".cubin"); }

std::optional<Program> CubinCache::load(const std::string& key) const {
    const std::string contents = read_file(file(key));
    std::string_view rest = contents;
    const auto kind = take_field(rest);
    const auto checksum = take_field(rest);
    if (!kind || *kind != format || !checksum || *checksum != digest_of(rest)) {
        return std::nullopt;
    }
    const auto seconds = take_field(rest);
    const auto log = take_field(rest);
    const auto cubin = take_field(rest);
    double compile_seconds = 0;
    if (!seconds || seconds->size() != sizeof compile_seconds || !log || !cubin) {
        return std::nullopt;
    }
    std::memcpy(&compile_seconds, seconds->data(), sizeof compile_seconds);
    return Program{.cubin = std::string(*cubin),
                   .log = std::string(*log),
                   .resources = parse_resources(*log),
                   .compile_seconds = compile_seconds};
}

void CubinCache::store(const std::string& key, const Program& program) const {
    const std::string_view seconds(reinterpret_cast<const char*>(&program.compile_seconds),
                                   sizeof program.compile_seconds);
    const std::string payload = field(seconds) + field(program.log) + field(program.cubin);
    fs::create_directories(directory_);
    const fs::path temporary = directory_ / temporary_name(key);
    std::ofstream stream(temporary, std::ios::binary);
    stream << field(format) << field(digest_of(payload)) << payload;
    stream.close();
    std::error_code problem;
    if (stream) {
        fs::rename(temporary, file(key), problem);
    } else {
        problem = std::make_error_code(std::errc::io_error);
    }
    if (problem) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw fs::filesystem_error("cannot write a compiled kernel", file(key), problem);
    }
}

std::string cache_key(const Translation& translation) {
    Sha256 hash;
    hash.update_field(format);
    hash.update_field(std::to_string(nvrtc_version()));
    hash.update_field(translation.name);
    hash.update_field(translation.source);
    const std::vector<std::string> options = compiler_options(translation);
    hash.update_field(std::to_string(options.size()));
    for (const std::string& option : options) {
        hash.update_field(option);
    }
    if (!translation.include_root.empty()) {
        for (const fs::path& header : headers_below(translation.include_root)) {
            hash.update_field(header.lexically_relative(translation.include_root).generic_string());
            hash.update_field(read_file(header));
        }
    }
    return hash.hex();
}

CachedProgram load_or_compile(const Translation& translation, const CubinCache& cache) {
    const Stopwatch watch;
    CachedProgram result;
    const std::string key = cache_key(translation);
    if (std::optional<Program> found = cache.load(key)) {
        result.program = std::move(*found);
        result.cached = true;
    } else {
        result.program = compile(translation);
        try {
            cache.store(key, result.program);
        } catch (const fs::filesystem_error& error) {
            result.cache_problem = error.what();
        }
    }
    result.seconds = watch.seconds();
    return result;
}

}  // namespace haste::cuda
