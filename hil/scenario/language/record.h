// What a scenario says about itself for reviews, beside what runs need: the basis of its data (measured, from a data
// sheet, assumed, derived; with uncertainty and source), parents and rationales of its requirements. It decides nothing
// in a run. `unlatch dossier` shows it, and the values that have no basis.
//
// Data are the numbers of the sections that describe the system and its surroundings, and what stands for numbers
// there: expressions, files of modes, meshes and tables. The step, outputs, limits of requirements and the like are no
// data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/scenario/text/quantity.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "hil/scenario/yaml/yaml_document.h"
#include "hil/scenario/yaml/yaml_pattern.h"

namespace unlatch::hil {

struct Scenario;

// An entry of `basis`.
struct Basis {
  enum class Kind { kMeasured, kDatasheet, kAssumed, kDerived };
  std::vector<PathPattern> of;
  Kind kind = Kind::kAssumed;
  std::optional<Quantity> uncertainty;  // standard uncertainty; plain: a part of the value
  std::string uncertainty_text, source;
  SourceMark mark;
};
extern const std::vector<std::string> kBasisNames;  // "measured" …, in the order of Basis::Kind

// The data of a key: a number, or a list of them.
struct DataValue {
  enum class Role { kModel, kInput };  // of the system; of its surroundings, start, commands and events
  std::string path;                    // "bodies.core.inertia"
  std::string text;                    // as written: "[1, 2, 3]"
  std::string unit;                    // SI; "": a plain number, or no number
  std::vector<double> numbers;         // in that unit, as far as they are numbers when the file is read
  SourceMark mark;
  Role role = Role::kModel;
  std::vector<std::string> constants;  // that it names
  bool is_expression = false;          // over quantities, channels, tables
  int basis = -1;                      // entry that covers it: the last one; -1: none

  // It has no basis of its own, but that of the constants from which it follows.
  [[nodiscard]] bool follows() const { return basis < 0 && !is_expression && !constants.empty(); }
};

// Of a requirement.
struct RequirementOrigin {
  std::string parent;     // identifier of the requirement that it follows from
  std::string rationale;  // why it is required
};

struct ScenarioRecord {
  std::vector<Basis> basis;
  std::vector<DataValue> values;
  std::vector<RequirementOrigin> requirements;  // as Scenario::requirements
};
// Reads the scenario's text once more.
ScenarioRecord load_record(const Scenario& scenario);

// Sections that have data.
const std::vector<std::string>& list_data_sections();

// The data of a tree, in its order. `mistakes` has read it with keep_numbers().
std::vector<DataValue> list_data(const YamlNode& root, const std::vector<Basis>& basis, const Mistakes& mistakes);

// Standard uncertainty of each number of a value, in its unit; empty if none is stated. A relative one is of the
// number's size.
std::vector<double> calc_uncertainties(const DataValue& value, const std::vector<Basis>& basis);

}  // namespace unlatch::hil
