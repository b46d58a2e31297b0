// Code shared by the fuzz targets. A target is LLVMFuzzerTestOneInput in one file: libFuzzer calls it with inputs that
// it generates (tools/fuzz), replay_main.cc with those in the repository (ctest). It returns 0 for any bytes; a finding
// ends the program.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <span>
#include <string>

#include "hil/run/run.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace unlatch::fuzz {

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "FOUND: %s\n", what);
  std::abort();
}

inline std::string to_text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

inline bool is_finite(const unlatch::State& state) {
  for (const BodyState& b : state.bodies) {
    for (const double number :
         {b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z, b.v.x, b.v.y, b.v.z, b.w.x, b.w.y, b.w.z})
      if (!std::isfinite(number)) return false;
  }
  return true;
}

// Steps a model from a file: any step ends in a status and leaves only finite numbers in its state. `look`: called with
// the report of each good step.
inline void step_a_little(hil::Simulation& simulation, const std::function<void(const StepReport&)>& look = {}) {
  constexpr int kSteps = 3;
  for (int i = 0; i < kSteps; ++i) {
    const StepReport report = simulation.step();
    if (report.status != StepStatus::kOk) break;
    require(is_finite(simulation.state()), "a number that is not finite in a state after a good step");
    if (look) look(report);
  }
}

// A scenario of one body under a force, a latch and an event: small, so that an execution is short.
inline const char* const kSmallScenario = R"(unlatch: 1
name: small
step: {dt: 0.001, until: 0.004}
bodies:
  core: {mass: 100, inertia: [10, 20, 25]}
  pod: {mass: 5, inertia: [1, 1, 1], position: [2, 0, 0]}
channels:
  throttle: {initial: 0.5, range: [0.2, 1], safe: 0.3}
joints:
  latch: {between: [core, pod], point: [2, 0, 0], modes: {held: {kind: weld}, free: {rows: []}}, mode: held}
elements:
  engine: {type: thrust, body: core, direction: [1, 0, 0], profile: 5000, channel: throttle}
sensors:
  gyro: {type: rate, body: core}
events:
  - {name: leave, subject: pod, when: {time: 0.0025}, then: [{set_mode: {joint: latch, mode: free}}]}
flight_software: {required: [fsw], timeout: 0.05, policy: hold}
)";

}  // namespace unlatch::fuzz
