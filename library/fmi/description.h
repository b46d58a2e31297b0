// modelDescription.xml of an FMU.
#pragma once

#include <string>
#include <vector>

#include "library/fmi/variables.h"

namespace unlatch::fmi {

struct Description {
  std::string name, identifier, token;
  double dt = 0, until = 0;          // s
  std::vector<std::string> sources;  // sources to compile; FMI 2.0 lists them here
};

// Text of the description. `version`: 2 or 3.
std::string describe(const Description& model, const std::vector<Variable>& variables, int version);

}  // namespace unlatch::fmi
