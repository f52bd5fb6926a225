#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "cuda/nvrtc.h"

namespace haste::cuda {

/// Compiled programs on disk, one file a program. Processes may share a cache: files are written
/// whole under another name and renamed. A file carries a checksum of its contents; one that is
/// truncated or damaged counts as absent and is replaced.
class CubinCache {
public:
    explicit CubinCache(std::filesystem::path directory) : directory_(std::move(directory)) {}

    /// $HASTE_CACHE, else $XDG_CACHE_HOME/haste, else ~/.cache/haste, each with `cubin` below it.
    /// Throws std::runtime_error if none of the three variables is set.
    [[nodiscard]] static CubinCache standard();

    /// The program stored under the key, if there is a sound one.
    [[nodiscard]] std::optional<Program> load(const std::string& key) const;

    /// Stores the program. Throws std::filesystem::filesystem_error if the directory refuses it.
    void store(const std::string& key, const Program& program) const;

    [[nodiscard]] std::filesystem::path file(const std::string& key) const;
    [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }

private:
    std::filesystem::path directory_;
};

/// SHA-256 of all that decides what a translation compiles to: source, the contents of every header
/// below the include directory, options, architecture and the version of NVRTC.
[[nodiscard]] std::string cache_key(const Translation& translation);

/// A program, and where it came from.
struct CachedProgram {
    Program program;
    bool cached = false;
    double seconds = 0;         ///< to load or compile it, the key's computation included
    std::string cache_problem;  ///< why it could not be stored; empty if all is well
};

/// Takes the program from the cache, or compiles and stores it. A cache that cannot be written
/// costs the next run a compilation and this run nothing. Throws CompileError.
[[nodiscard]] CachedProgram load_or_compile(const Translation& translation,
                                            const CubinCache& cache);

}  // namespace haste::cuda
