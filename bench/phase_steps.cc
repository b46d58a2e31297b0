// Steps the five-body boosters from `first` for `count` ticks, chosen without events: bench/instructions counts its
// instructions. Usage: phase_steps FIRST COUNT
#include <cstdio>
#include <cstdlib>

#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"

int main(int argc, char** argv) {
  using namespace unlatch;
  const int first = argc == 3 ? std::atoi(argv[1]) : -1, count = argc == 3 ? std::atoi(argv[2]) : 0;
  if (first < 0 || count < 1) {
    std::fprintf(stderr, "usage: phase_steps FIRST COUNT (ticks of 1 ms)\n");
    return 2;
  }
  test::Simulation simulation(test::build_soyuz(test::load_reference("soyuz_nominal")));
  for (int tick = 0; tick < first + count; ++tick) {
    const StepReport report = simulation.advance();
    if (report.status != StepStatus::kOk) {
      std::fprintf(stderr, "phase_steps: %s at tick %d\n", get_status_text(report.status), tick);
      return 1;
    }
    if (tick >= first && !report.events.empty()) std::printf("events at tick %d\n", tick);
  }
  return 0;
}
