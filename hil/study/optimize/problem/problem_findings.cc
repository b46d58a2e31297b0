#include "hil/study/optimize/problem/problem_findings.h"

namespace unlatch::hil {

std::vector<CampaignFinding> list_problem_findings(const OptimizeProblem& problem) {
  constexpr std::size_t kGroups = 3;  // of variables that are at the same end: 2^3 corners
  static_assert(1 << kGroups == kFindingCorners);
  std::vector<std::vector<Setting>> corners;
  for (unsigned corner = 0; corner < kFindingCorners; ++corner) {
    OptimizePoint point;
    for (std::size_t i = 0; i < problem.variables.size(); ++i) {
      const OptimizeVariable& variable = problem.variables[i];
      point.push_back(((corner >> (i % kGroups)) & 1U) != 0 ? variable.upper : variable.lower);
    }
    corners.push_back(make_settings(problem, point));
  }
  return list_findings_of_corners(*problem.tree, corners);
}

}  // namespace unlatch::hil
