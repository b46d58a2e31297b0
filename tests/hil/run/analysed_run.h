// A scenario run to its end, and its analysis.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/run.h"

namespace unlatch::test {

struct AnalysedRun {
  explicit AnalysedRun(const std::string& text)
      : scenario(hil::load_scenario_text(text, "run.yaml")),
        simulation(hil::build_simulation(scenario)),
        analysis(scenario, *simulation) {
    analysis.update(StepReport{});
    const std::int64_t last = hil::calc_nearest_tick(scenario.until, scenario.dt);
    while (simulation->get_tick() < last) {
      const StepReport report = simulation->step();
      EXPECT_EQ(report.status, StepStatus::kOk);
      if (report.status != StepStatus::kOk) return;
      analysis.update(report);
    }
  }
  // The verdict on the requirement of this id.
  [[nodiscard]] hil::Verdict judge(const std::string& id) const {
    for (const hil::Verdict& verdict : analysis.judge())
      if (scenario.requirements[verdict.requirement].id == id) return verdict;
    ADD_FAILURE() << "no requirement " << id;
    return {};
  }

  const hil::Scenario scenario;
  const std::unique_ptr<hil::Simulation> simulation;
  hil::RunAnalysis analysis;
};

// Notices of the search for events.
inline std::vector<hil::RunNotice> list_searches(const AnalysedRun& run) {
  std::vector<hil::RunNotice> found;
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == "search") found.push_back(notice);
  return found;
}

}  // namespace unlatch::test
