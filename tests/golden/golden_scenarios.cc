// golden_scenarios [--lanes NAME] FILE...: prints the hashes of scenarios, run to their end without flight software.
// The name in the output is the file's folder and stem: boosters/reference.
#include <cmath>
#include <exception>
#include <filesystem>

#include "hil/scenario/scenario.h"
#include "tests/golden/golden_run.h"

int main(int argc, char** argv) {
  int first = 0;
  const unlatch::InstructionSet set = unlatch::test::read_instruction_set(argc, argv, first);
  bool all = true;
  for (int i = first; i < argc; ++i) {
    const std::filesystem::path file = argv[i];
    const std::string name = (file.parent_path().filename() / file.stem()).string();
    try {
      const unlatch::hil::Scenario scenario = unlatch::hil::load_scenario(file.string());
      const auto ticks = static_cast<std::int64_t>(std::llround(scenario.until / scenario.dt));
      all &= unlatch::test::print_golden_hashes(name.c_str(), scenario.model, scenario.dt, ticks, set);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
      all = false;
    }
  }
  return all ? 0 : 1;
}
