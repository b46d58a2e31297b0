// Flexible bodies and loops, compared with the same without SIMD lanes, and with rigid bodies.
//   flexible/<system>/<set>       a full step of the elastic fairing, and of panels with cables (loops), by instruction
//                                 set: `scalar` computes one body after the other
//   flexible/<kind>/<shape>/<n>   accelerations from poses and velocities of n masts on hinges, `rigid` or with `four`
//                                 modes each. items: bodies
#include <benchmark/benchmark.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "bench/least.h"
#include "hil/run/run.h"
#include "tests/support/modal_model.h"
#include "tests/support/simulation.h"

namespace unlatch::bench {
namespace {

constexpr int kBays = 4, kModes = 4;
constexpr int kFirstTick = 200, kWindow = 80;  // ticks of the scenarios

struct SetName {
  const char* name;
  InstructionSet set;
};
constexpr SetName kSets[] = {{"scalar", InstructionSet::kScalar},
                             {"128", InstructionSet::k128},
                             {"256", InstructionSet::k256},
                             {"512", InstructionSet::k512}};

// Repeats the same ticks.
void repeat_steps(benchmark::State& bench, const char* path, InstructionSet set) {
  const hil::Scenario scenario = hil::load_scenario(std::string(UNLATCH_SOURCE_DIR "/hil/scenarios/") + path);
  test::Simulation simulation(scenario.model, {.dt = scenario.dt, .instruction_set = set});
  for (int i = 0; i < kFirstTick; ++i) (void)simulation.advance();
  const std::span<std::byte> state = simulation.state.get_bytes();
  const std::vector<std::byte> saved(state.begin(), state.end());
  for (auto _ : bench) {
    if (simulation.state.header->tick >= kFirstTick + kWindow) std::copy(saved.begin(), saved.end(), state.begin());
    if (simulation.advance().status != StepStatus::kOk) bench.SkipWithError("a step failed");
  }
  bench.SetItemsProcessed(bench.iterations() * static_cast<std::int64_t>(scenario.model.bodies.size()));
}

// Builds n masts, each on a hinge about y at the tip of its parent: the one before in a chain, the first in a star.
Model build_masts(bool flexible, bool chain, int n) {
  const test::ModalBody lumped = test::build_lattice_mast(kBays, kModes, test::Support::kFree);
  const std::size_t root = 0, tip = lumped.positions.size() - 1;
  const Eigen::Matrix3Xd no_turn = Eigen::Matrix3Xd::Zero(3, kModes);
  const Eigen::Vector3d step = lumped.positions[tip] - lumped.positions[root];
  Model model;
  model.name = "masts";
  model.gravity.uniform = {0, 0, -9.81};
  std::vector<int> masts, tips, roots;  // attachment points of joints: markers, or the bodies themselves
  const auto add_marker = [&](int mast, std::size_t particle, const char* name) {
    if (!flexible) return mast;
    model.bodies.push_back(test::build_marker(name + std::to_string(mast), mast, lumped, particle, no_turn));
    return static_cast<int>(model.bodies.size()) - 1;
  };
  for (int i = 0; i < n; ++i) {
    Body body = test::build_flexible_body("mast" + std::to_string(i), lumped);
    if (!flexible) body.flexible.reset();
    body.p_WB = (i == 0 ? 0.0 : chain ? static_cast<double>(i) : 1.0) * step;
    masts.push_back(static_cast<int>(model.bodies.size()));
    model.bodies.push_back(body);
    tips.push_back(chain || i == 0 ? add_marker(masts.back(), tip, "tip") : kGround);
    roots.push_back(i > 0 ? add_marker(masts.back(), root, "root") : kGround);
  }
  for (int i = 1; i < n; ++i) {
    Joint joint;
    joint.name = "hinge" + std::to_string(i);
    joint.base = tips[static_cast<std::size_t>(chain ? i - 1 : 0)];
    joint.follower = roots[static_cast<std::size_t>(i)];
    if (!flexible) {
      joint.point_base = lumped.positions[tip];
      joint.point_follower = lumped.positions[root];
    }
    joint.modes = {{"hinge", static_cast<RowSet>(kPointRows | row_bit(kRotX) | row_bit(kRotZ))}};
    model.joints.push_back(joint);
  }
  return model;
}

void solve_masts(benchmark::State& bench, bool flexible, bool chain, InstructionSet set) {
  const int n = static_cast<int>(bench.range(0));
  test::Simulation simulation(build_masts(flexible, chain, n), {.instruction_set = set});
  if (test::evaluate_state(simulation) != kNone) return bench.SkipWithError("a pivot vanished");
  for (auto _ : bench) benchmark::DoNotOptimize(test::evaluate_state(simulation, Changed::kMotion));
  bench.SetItemsProcessed(bench.iterations() * n);
}

bool register_all() {
  struct System {
    const char* name;
    const char* path;
  };
  for (const SetName& set : kSets) {
    if (!is_supported(set.set)) continue;
    for (const System& system : {System{"fairing", "fairing/scenario.yaml"}, System{"elastic", "array/elastic.yaml"},
                                 System{"cables", "array/elastic-cables.yaml"}})
      keep_least(
          benchmark::RegisterBenchmark(("flexible/" + std::string(system.name) + "/" + set.name).c_str(),
                                       [=](benchmark::State& bench) { repeat_steps(bench, system.path, set.set); }));
    for (const bool chain : {false, true})
      for (const bool flexible : {false, true})
        keep_least(
            benchmark::RegisterBenchmark(
                ("flexible/" + std::string(flexible ? "four/" : "rigid/") + (chain ? "chain/" : "star/") + set.name)
                    .c_str(),
                [=](benchmark::State& bench) { solve_masts(bench, flexible, chain, set.set); })
                ->Arg(5)
                ->Arg(64));
  }
  return true;
}
const bool registered = register_all();

}  // namespace
}  // namespace unlatch::bench
