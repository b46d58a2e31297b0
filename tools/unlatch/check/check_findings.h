// Findings of `check` about a valid scenario: its springs at the start, and facts that an engineer would want to know
// before the run.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hil/run/findings/finding.h"
#include "hil/run/findings/spring_start.h"

namespace unlatch::tools {

// "file:12:3", of an element of the scenario; empty if it has no place.
std::string get_place(const hil::Scenario& scenario, const std::string& where);

void print_springs(std::FILE* to, const std::vector<hil::SpringStart>& springs);
void print_findings(std::FILE* to, const hil::Scenario& scenario, const std::vector<hil::Finding>& findings);

nlohmann::ordered_json build_springs_json(const std::vector<hil::SpringStart>& springs);
nlohmann::ordered_json build_findings_json(const hil::Scenario& scenario, const std::vector<hil::Finding>& findings);

}  // namespace unlatch::tools
