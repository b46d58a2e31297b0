// The reader of fault scripts, and the injector of faults.
#include "hil/session/faults/fault_injector.h"
#include "hil/session/faults/fault_script.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

void pass(hil::FaultInjector& faults, hil::Direction direction, const hil::Message& said, std::int64_t now_ns) {
  constexpr int kMany = 4096;  // more than all copies of a few messages
  hil::Message heard;
  std::int64_t arrived_ns = 0;
  faults.offer(direction, said, now_ns, now_ns, "fsw");
  int count = 0;
  while (faults.take(direction, now_ns, heard, arrived_ns)) {
    fuzz::require(hil::is_well_formed(heard), "a message that no port would have let through");
    fuzz::require(++count < kMany, "messages without end");
  }
}

// Runs a few ticks with a message each way.
void run(const hil::FaultScript& script) {
  constexpr std::int64_t kTicks = 4, kTick_ns = 1'000'000;
  hil::FaultInjector faults(script);
  hil::Participants participants({"fsw"});
  hil::HelloAckMessage hello;
  hil::set_name(hello.name, "fsw");
  (void)participants.admit(hello);
  hil::FaultNotice notice;
  for (std::int64_t tick = 0; tick < kTicks; ++tick) {
    const std::int64_t now_ns = (tick + 1) * kTick_ns;
    const auto resume = [](hil::Participant&) {};
    faults.begin_tick(tick, now_ns, participants, resume);
    faults.end_timed_freezes(now_ns, participants, resume);
    hil::StateMessage state;
    state.tick = tick;
    state.parts = 1;
    faults.distort(state);
    (void)faults.get_forced(0, 0.5);
    pass(faults, hil::Direction::kOut, state, now_ns);
    hil::StepAckMessage ack;
    ack.tick = tick;
    pass(faults, hil::Direction::kIn, ack, now_ns);
    while (faults.take_notice(notice)) fuzz::require(notice.fault != nullptr, "a notice of no fault");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const hil::Scenario scenario = hil::load_scenario_text(fuzz::kSmallScenario, "small.yaml");
  try {
    const hil::FaultScript script = hil::load_faults_text(fuzz::to_text(data, size), "faults.yaml", scenario);
    for (const hil::Fault& fault : script.faults) {
      fuzz::require(fault.first_tick <= fault.last_tick, "ticks that end before they begin");
      fuzz::require(fault.channel < static_cast<int>(scenario.model.channels.size()), "a channel that is none");
    }
    run(script);
  } catch (const hil::ScenarioError& error) {
    fuzz::require(!error.mistakes.empty(), "a refusal without a mistake");
  }
  return 0;
}
