#pragma once

#include <map>
#include <string>

namespace haste {

/// How the extension was compiled, for the provenance of a measurement. Keys: version, compiler,
/// flags, build_type, embree, tbb, processor.
[[nodiscard]] std::map<std::string, std::string> build_info();

}  // namespace haste
