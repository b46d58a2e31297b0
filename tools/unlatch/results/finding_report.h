// Findings about a scenario, as `check` and every run report them: facts that an engineer would want to know before the
// run, and beside its result.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hil/run/findings/finding.h"
#include "hil/scenario/scenario.h"

namespace unlatch::tools {

// "file:12:3", of an element of the scenario; empty if it has no place.
std::string get_place(const hil::Scenario& scenario, const std::string& where);

void print_findings(std::FILE* to, const hil::Scenario& scenario, const std::vector<hil::Finding>& findings);
nlohmann::ordered_json build_findings_json(const hil::Scenario& scenario, const std::vector<hil::Finding>& findings);

// Findings of a scenario that has run: those of its start.
std::vector<hil::Finding> list_warnings(const hil::Scenario& scenario);

}  // namespace unlatch::tools
