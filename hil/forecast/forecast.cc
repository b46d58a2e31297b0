#include "hil/forecast/forecast.h"

#include "hil/forecast/surprises.h"
#include "hil/scenario/requirements_check.h"

namespace unlatch::hil {

std::vector<Finding> find_surprises(const Scenario& scenario, const Simulation& simulation) {
  const Model model = place_markers(scenario.model);
  std::vector<Finding> findings;
  for (const Remark& remark : scenario.remarks) findings.push_back({remark.kind, remark.where, remark.text});
  find_plates(model, findings);
  find_joint_surprises(model, findings);
  find_directionless(model, findings);
  find_free_springs(scenario, findings);
  find_overlaps(scenario, findings);
  find_intruders(scenario, findings);
  find_event_surprises(scenario, findings);
  find_step_surprises(scenario, simulation, findings);
  for (const RequirementProblem& problem : find_trivial(scenario))
    findings.push_back({"trivial", quoted("requirement", scenario.requirements[problem.requirement].id),
                        problem.what + "; " + problem.mend});
  return findings;
}

}  // namespace unlatch::hil
