#include "hil/run/findings/findings.h"

#include "hil/run/findings/finding_parts.h"
#include "hil/scenario/requirements_check.h"

namespace unlatch::hil {

std::vector<Finding> list_findings(const Scenario& scenario, const Simulation& simulation) {
  const Model model = place_markers(scenario.model);
  std::vector<Finding> findings;
  for (const Remark& remark : scenario.remarks) findings.push_back({remark.kind, remark.where, remark.text});
  add_inertia_findings(model, findings);
  add_joint_findings(model, findings);
  add_coincident_point_findings(model, findings);
  add_freed_spring_findings(scenario, findings);
  add_overlap_findings(scenario, findings);
  add_unwatched_overlap_findings(scenario, findings);
  add_event_findings(scenario, findings);
  add_step_findings(scenario, simulation, findings);
  add_law_findings(scenario, simulation, findings);
  for (const RequirementProblem& problem : find_trivial(scenario))
    findings.push_back({"trivial", quoted("requirement", scenario.requirements[problem.requirement].id),
                        problem.what + "; " + problem.mend});
  return findings;
}

}  // namespace unlatch::hil
