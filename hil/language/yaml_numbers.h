// The numbers that a text writes out: each with the path by which an override reaches it. Numbers that follow from the
// scenario's constants are not among them: the constant is what one sets.
#pragma once

#include <string>
#include <vector>

#include "hil/language/scenario_error.h"
#include "hil/language/yaml_document.h"

namespace unlatch::hil {

struct WrittenNumber {
  std::string path;  // as overrides write it: "bodies.core.mass", "gravity[2]"
  std::string unit;  // SI; "" for a plain number
  double value = 0;  // in that unit
};

// In the order of the tree. `mistakes` has read the tree with keep_numbers().
std::vector<WrittenNumber> list_written_numbers(const YamlNode& root, const Mistakes& mistakes);

}  // namespace unlatch::hil
