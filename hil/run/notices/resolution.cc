#include "hil/run/notices/resolution.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <set>

namespace unlatch::hil {
namespace {

constexpr std::size_t kMostCombinations = 64;
using Combination = std::vector<int>;  // a mode of each joint

RowSet get_rows(const Joint& joint, int mode) { return joint.modes[static_cast<std::size_t>(mode)].rows; }

// Lists those reachable modes whose rows include no other mode's rows.
std::vector<int> find_loosest_modes(const Model& model, int j) {
  const Joint& joint = model.joints[static_cast<std::size_t>(j)];
  const std::vector<int> reachable = find_reachable_modes(model, j);
  std::vector<int> loosest;
  for (const int mode : reachable) {
    const RowSet rows = get_rows(joint, mode);
    const bool is_bound = std::any_of(reachable.begin(), reachable.end(), [&](int other) {
      const RowSet fewer = get_rows(joint, other);
      return (fewer != rows && (fewer & rows) == fewer) || (fewer == rows && other < mode);
    });
    if (!is_bound) loosest.push_back(mode);
  }
  return loosest;
}

std::vector<Combination> find_combinations(const Model& model) {
  std::vector<std::vector<int>> choices;
  Combination fewest;
  std::size_t count = 1;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    choices.push_back(find_loosest_modes(model, static_cast<int>(j)));
    fewest.push_back(*std::min_element(choices[j].begin(), choices[j].end(), [&](int a, int b) {
      return std::popcount(get_rows(model.joints[j], a)) < std::popcount(get_rows(model.joints[j], b));
    }));
    count = std::min(count * choices[j].size(), kMostCombinations + 1);
  }
  std::vector<Combination> combinations{fewest};
  const bool all = count <= kMostCombinations;
  for (std::size_t j = 0; j < choices.size(); ++j) {
    const std::size_t before = all ? combinations.size() : 1;
    for (std::size_t i = 0; i < before; ++i)
      for (const int mode : choices[j]) {
        if (mode == fewest[j]) continue;
        Combination other = combinations[i];
        other[j] = mode;
        combinations.push_back(other);
      }
  }
  return combinations;
}

// A state and a workspace for trying modes.
class Trial {
 public:
  explicit Trial(const Simulation& simulation)
      : plan_(simulation.plan()),
        block_(simulation.plan().get_state_bytes() / sizeof(std::uint64_t)),
        memory_(simulation.plan().get_workspace_bytes() + kAlignment),
        state_(plan_, std::as_writable_bytes(std::span(block_))) {
    const std::span<const std::byte> bytes = simulation.state().get_bytes();
    std::memcpy(block_.data(), bytes.data(), bytes.size());
    void* first = memory_.data();
    std::size_t space = memory_.size();
    const std::size_t bytes_needed = plan_.get_workspace_bytes();
    workspace_ =
        Workspace(plan_, {static_cast<std::byte*>(std::align(kAlignment, bytes_needed, first, space)), bytes_needed});
  }
  std::vector<ElementFrequency> calc(const Combination& modes) {
    for (std::size_t j = 0; j < modes.size(); ++j) state_.joints[j].mode = modes[j];
    return calc_frequencies(plan_, state_, workspace_);
  }
  std::vector<ElementMobility> calc_mobilities() { return unlatch::calc_mobilities(plan_, state_, workspace_); }

 private:
  static constexpr std::size_t kAlignment = 64;
  const Plan& plan_;
  std::vector<std::uint64_t> block_;
  std::vector<std::byte> memory_;
  State state_;
  Workspace workspace_;
};

std::string describe(const Model& model, const Combination& initial, const Combination& modes) {
  std::string text;
  for (std::size_t j = 0; j < modes.size(); ++j) {
    if (modes[j] == initial[j]) continue;
    const Joint& joint = model.joints[j];
    text += (text.empty() ? "" : ", ") + joint.name + " " + joint.modes[static_cast<std::size_t>(modes[j])].name;
  }
  return text;
}

}  // namespace

std::vector<ElementMobility> calc_mobilities(const Simulation& simulation) {
  return Trial(simulation).calc_mobilities();
}

std::vector<int> find_reachable_modes(const Model& model, int joint) {
  std::set<int> modes{model.joints[static_cast<std::size_t>(joint)].mode};
  for (const Event& event : model.events)
    for (const Action& action : event.then)
      if (action.kind == Action::Kind::kSetMode && action.subject == joint) modes.insert(action.mode);
  return {modes.begin(), modes.end()};
}

std::vector<SpringResolution> calc_resolutions(const Simulation& simulation) {
  const Model& model = simulation.model();
  Trial trial(simulation);
  Combination initial;
  for (const Joint& joint : model.joints) initial.push_back(joint.mode);
  std::vector<SpringResolution> springs;
  for (const ElementFrequency& e : trial.calc(initial))
    springs.push_back({e.element, e.implicit, e.omega, e.decay, e.omega, e.decay, ""});
  if (springs.empty()) return springs;
  for (const Combination& modes : find_combinations(model)) {
    const std::vector<ElementFrequency> found = trial.calc(modes);
    for (std::size_t i = 0; i < found.size(); ++i) {  // absent if a pivot vanishes
      SpringResolution& spring = springs[i];
      constexpr double kNoteworthy = 1 + 1e-9;  // relative to the present largest
      if (std::max(found[i].omega, found[i].decay) <= kNoteworthy * spring.get_worst()) continue;
      spring.largest_omega = found[i].omega;
      spring.largest_decay = found[i].decay;
      spring.where = describe(model, initial, modes);
    }
  }
  return springs;
}

}  // namespace unlatch::hil
