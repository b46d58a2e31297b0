// Overrides --set PATH=VALUE, one a line, on top of a valid scenario.
#include <sstream>

#include "tests/fuzz/fuzz.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMaxOverrides = 16;
  std::istringstream lines(fuzz::to_text(data, size));
  std::vector<std::string> overrides;
  for (std::string line; overrides.size() < kMaxOverrides && std::getline(lines, line);) overrides.push_back(line);
  try {
    const auto simulation =
        hil::build_simulation(hil::load_scenario_text(fuzz::kSmallScenario, "small.yaml", overrides));
    fuzz::step_a_little(*simulation);
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
  return 0;
}
