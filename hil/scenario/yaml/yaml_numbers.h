// Numbers that a text contains literally: each with the path by which an override reaches it. Numbers that follow from
// the scenario's constants are excluded: the constant is set instead.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/yaml/scenario_error.h"
#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

struct WrittenNumber {
  std::string path;  // path as in overrides: "bodies.core.mass", "gravity[2]"
  std::string unit;  // SI; "" for a plain number
  double value = 0;  // in that unit
};

// Lists numbers in the order of the tree. `mistakes` has read the tree with keep_numbers().
std::vector<WrittenNumber> list_written_numbers(const YamlNode& root, const Mistakes& mistakes);

}  // namespace unlatch::hil
