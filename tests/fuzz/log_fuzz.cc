// The reader of recordings, and their replay.
#include "hil/run/replay.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/reseal.h"

using namespace unlatch;

namespace {

void read(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMaxBodies = 8;  // limit for a short replay
  try {
    fuzz::MemoryFile file(bytes);
    hil::RecordingReader recording(file.open());
    recording.keeps_states = true;
    const hil::Scenario scenario = hil::load_recorded_scenario(recording.header);
    if (scenario.model.bodies.size() > kMaxBodies) return;
    const auto simulation = hil::build_recorded_simulation(recording.header, scenario, "memory");
    (void)hil::replay(recording, *simulation, nullptr);
    fuzz::require(fuzz::is_finite(simulation->state()), "a number that is not finite in a replayed state");
  } catch (const hil::LogError&) {
  } catch (const hil::ScenarioError&) {
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span bytes(data, size);
  read(bytes);
  read(fuzz::reseal(bytes));
  return 0;
}
