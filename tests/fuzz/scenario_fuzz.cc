// The scenario loader: a text gives a scenario, or a ScenarioError; a loaded scenario compiles and steps, or gives a
// reason.
#include "hil/run/analysis/run_analysis.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMaxBodies = 32;  // limit for short steps
  try {
    const hil::Scenario scenario = hil::load_scenario_text(fuzz::to_text(data, size), "fuzz.yaml");
    if (scenario.model.bodies.size() > kMaxBodies) return 0;
    const auto simulation = hil::build_simulation(scenario);
    hil::RunAnalysis analysis(scenario, *simulation);
    analysis.update(StepReport{});
    fuzz::step_a_little(*simulation, [&](const StepReport& report) { analysis.update(report); });
    for (const hil::Verdict& verdict : analysis.judge())
      fuzz::require(verdict.evaluated || !verdict.why.empty(), "a requirement that is not evaluated, without a reason");
    (void)analysis.list_separations();
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
  return 0;
}
