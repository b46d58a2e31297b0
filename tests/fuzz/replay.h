// The fuzz targets in the program fuzz_replay.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace unlatch::fuzz {

struct Target {
  const char* name;
  int (*test_one_input)(const std::uint8_t* data, std::size_t size);
};

// All of them: a file that CMakeLists.txt writes.
const std::vector<Target>& list_targets();

}  // namespace unlatch::fuzz
