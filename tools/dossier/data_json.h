// The data of a scenario and their basis, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hil/scenario/language/record.h"
#include "hil/scenario/scenario.h"

namespace unlatch::tools {

// Values by what is known of them. Each value counts once.
struct BasisCounts {
  std::size_t all = 0, none = 0, follow = 0;
  std::vector<std::size_t> of_kinds;  // in the order of hil::kBasisNames
  std::size_t uncertain = 0;          // of those with a basis: with an uncertainty
};
BasisCounts count_basis(const hil::ScenarioRecord& record, hil::DataValue::Role role);

// "12 of 80 values have a basis: 10 measured, 2 assumed; 60 follow from constants; 8 have none"
std::string describe(const BasisCounts& counts);

// {counts: {model: {…}, input: {…}}, values: [{path, text, unit, numbers, role, basis, uncertainty, …, place}]}
nlohmann::ordered_json build_data_json(const hil::Scenario& scenario, const hil::ScenarioRecord& record);

// A file of the scenario as seen from its folder.
std::string get_name_from_folder(const hil::Scenario& scenario, int file);

}  // namespace unlatch::tools
