// modelDescription.xml of an FMU, FMI 2.0 and 3.0: what a co-simulation master needs of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace unlatch::fmu {

struct Variable {
  enum class Kind { kReal, kBoolean, kOther };
  enum class Causality { kInput, kOutput, kOther };
  std::string name;
  std::uint32_t reference = 0;
  Kind kind = Kind::kOther;
  Causality causality = Causality::kOther;
  bool array = false;
  std::string unit;  // its name; empty: none
};

struct Description {
  int version = 0;         // 2 or 3
  std::string token;       // guid, instantiationToken
  std::string identifier;  // of the binary; a C identifier
  std::vector<Variable> variables;
  std::vector<std::string> scaled_units;  // names of units that are not those of SI, as their definitions say
};

// Throws FmuError.
Description read_description(const std::string& xml);

}  // namespace unlatch::fmu
