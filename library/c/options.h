// Reading and checking of unlatch_options.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "library/include/unlatch.h"

namespace unlatch::library {

struct LoadOptions {
  std::vector<std::string> overrides;
  std::uint32_t flags = 0;
  std::size_t event_capacity = 4096;
};

// Reads options, which may be null. If they are refused, returns false and sets this thread's error.
[[nodiscard]] bool read_options(const unlatch_options* options, LoadOptions& read);

}  // namespace unlatch::library
