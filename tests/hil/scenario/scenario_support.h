// A small valid scenario, and the loader's messages for invalid ones.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hil/scenario/scenario.h"

namespace unlatch::test {

// Returns true for a scenario, false for a campaign or an optimisation problem, which refer to scenarios and have a key
// of their own.
inline bool is_scenario_file(const std::filesystem::path& path) {
  if (path.extension() != ".yaml") return false;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("unlatch:")) return true;
  return false;
}

// Scenario with every section once. Line 1 is `unlatch: 1`.
inline const char* const kGoodScenario = R"(unlatch: 1
name: pair
step: {dt: 0.001, until: 1}
bodies:
  core:
    mass: 100
    inertia: [10, 20, 25]
    shape: [{sphere: {radius: 1}}]
  booster:
    mass: 4.5 t
    inertia: [5, 6, 7]
    relative_to: core
    position: [3, 0, 0]
    shape: [{capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 0}}]
channels:
  throttle: {initial: 1, range: [0, 1], safe: 0}
joints:
  nose:
    between: [core, booster]
    point: [2, 0, 0]
    follower_point: [-1, 0, 0]
    modes:
      hinge: {kind: revolute, axis: y}
      free: {rows: []}
    mode: hinge
elements:
  engine: {type: thrust, body: core, direction: [1, 0, 0], profile: 5 kN, channel: throttle}
  spring: {type: spring, between: [core, booster], stiffness: 10, free_length: 1}
sensors:
  gyro: {type: rate, body: core}
  kr: {type: contact, signal: kr}
events:
  - name: contact
    subject: booster
    when: {displacement: {joint: nose, axis: x}, below: -5 mm}
    delay: 12 ms
    then: [{raise: kr}, {set_mode: {joint: nose, mode: free}}]
clearance: all
flight_software: {required: [fsw], timeout: 0.5, policy: safe}
points:
  aft: {body: booster, at: [-1, 0, 50 mm], seen_from: core}
  fore: {body: core}
)";

inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("test text has no '" + what + "'");
  return text.replace(at, what.size(), with);
}

// Returns the mistakes, one line each, "" if there are none.
inline std::string load_errors(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    hil::load_scenario_text(text, "s.yaml", overrides);
    return "";
  } catch (const hil::ScenarioError& e) {
    return e.what();
  }
}

// Returns the messages of the loader if one piece of the good scenario is replaced.
inline std::string errors_with(const std::string& what, const std::string& with) {
  return load_errors(replaced(kGoodScenario, what, with));
}

}  // namespace unlatch::test
