// `unlatch check --cost`: what a step costs at most on a target (unlatch/cost/step_cost.h), for people and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "unlatch/cost/step_cost.h"

namespace unlatch::tools {

struct CostOptions {
  std::string target;  // empty: no bound is asked for
  double cycles = 1;   // of an instruction, on average: the cost model of a processor
  double clock = 0;    // MHz; 0: no times
};

std::vector<std::string> list_cost_target_names();

void print_cost(const hil::Scenario& scenario, const Plan& plan, const CostOptions& options);
nlohmann::ordered_json build_cost_json(const hil::Scenario& scenario, const Plan& plan, const CostOptions& options);

}  // namespace unlatch::tools
