// unlatch_options, read and checked.
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

// `options` may be null. False, and an error of this thread, if they are refused.
[[nodiscard]] bool read_options(const unlatch_options* options, LoadOptions& read);

}  // namespace unlatch::library
