// Runs bridge/stacks/fprime/UnlatchSim.cpp in a loop of our own, with a component that flies bridge/examples/probe.yaml
// like the pilot: throttle open at tick 100, shut at tick 300. Exit code 1 if it warned.
#include "UnlatchSim.hpp"

int main() {
  static Unlatch::UnlatchSim sim("sim");
  if (!sim.configure("pilot", "127.0.0.1", 7670)) return 2;
  bool sound = true;
  sim.set_stateOut([&](I64 tick, I64 time_ns, U32 count, Unlatch::SensorValues&) {
    sound = sound && count == 3 && time_ns == tick * 1'000'000 && sim.getTimeNs() == time_ns;
    if (tick == 100) sim.call_commandIn("throttle", 1);
    if (tick == 300) sim.call_commandIn("throttle", 0);
  });
  for (int idle = 0; sim.isActive() && idle < 1'000'000; ++idle) sim.call_schedIn(0);
  if (sim.warnings > 0) sound = false;
  sim.call_commandIn("throttle", 1);  // after the session: refused
  return sound && !sim.isActive() && sim.warnings == 1 ? 0 : 1;
}
