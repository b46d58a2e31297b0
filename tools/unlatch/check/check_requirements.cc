// Findings of `unlatch check` about requirements.
#include <nlohmann/json.hpp>

#include "hil/scenario/requirements_check.h"
#include "tools/common/terminal.h"
#include "tools/unlatch/check/check_json.h"

namespace unlatch::tools {

void print_requirement_checks(const hil::Scenario& scenario) {
  if (scenario.requirements.empty()) return;
  std::printf("\n%s\n", paint(stdout, Colour::kBold, "Requirements").c_str());
  const std::vector<hil::RequirementProblem> problems = hil::find_problems(scenario);
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i) {
    const hil::Requirement& requirement = scenario.requirements[i];
    std::printf("  %-16s %s%s%s\n", requirement.id.c_str(), hil::describe_quantity(requirement, scenario.model).c_str(),
                requirement.text.empty() ? "" : ": ", requirement.text.c_str());
    for (const hil::RequirementProblem& problem : problems) {
      if (problem.requirement != i) continue;
      const std::string text = "cannot be evaluated: " + problem.what + "; " + problem.mend;
      std::printf("  %-16s %s\n", "", paint(stdout, Colour::kYellow, text).c_str());
    }
  }
}

nlohmann::ordered_json build_requirement_checks(const hil::Scenario& scenario) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const hil::Requirement& requirement : scenario.requirements) {
    list.push_back({{"id", requirement.id},
                    {"quantity", hil::describe_quantity(requirement, scenario.model)},
                    {"problems", nlohmann::ordered_json::array()}});
  }
  for (const hil::RequirementProblem& problem : hil::find_problems(scenario))
    list[problem.requirement]["problems"].push_back({{"what", problem.what}, {"mend", problem.mend}});
  return list;
}

}  // namespace unlatch::tools
