// Steps a model from `first` for `count` ticks, chosen without events: bench/instructions counts its instructions.
// Usage: phase_steps MODEL FIRST COUNT. MODEL: boosters, or one of sixteen pairs of shapes, of which four are closed
// (closed) or none (open).
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/support/contact_models.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"

namespace {

using namespace unlatch;

// The same pairs as `closed`, lifted off the floor. They fall, and do not reach it within 0.3 s.
Model build_open_pairs() {
  Model model = test::build_sixteen_pairs();
  constexpr double kLift = 0.5, kSpread = 1.5;  // m; of the places
  for (Body& body : model.bodies) {
    body.p_WB *= kSpread;
    body.p_WB.z() += kLift;
  }
  return model;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc == 4 ? argv[1] : "";
  const int first = argc == 4 ? std::atoi(argv[2]) : -1, count = argc == 4 ? std::atoi(argv[3]) : 0;
  const bool known = name == "boosters" || name == "closed" || name == "open";
  if (!known || first < 0 || count < 1) {
    std::fprintf(stderr, "usage: phase_steps boosters|closed|open FIRST COUNT (ticks of 1 ms)\n");
    return 2;
  }
  test::Simulation simulation(name == "boosters" ? test::build_soyuz(test::load_reference("soyuz_nominal"))
                              : name == "closed" ? test::build_sixteen_pairs()
                                                 : build_open_pairs());
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
