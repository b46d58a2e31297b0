// The warning of graphs whose loops cost much.
#include <gtest/gtest.h>

#include <string>

#include "hil/run/findings/findings.h"
#include "hil/run/run.h"

namespace unlatch::test::loop_finding_test {
namespace {

// Bodies at one point, each held to each other by a ball joint.
std::string build_knot(int bodies) {
  std::string text = "unlatch: 1\nname: knot\nstep: {dt: 1 ms, until: 0.01}\nbodies:\n";
  for (int b = 0; b < bodies; ++b) text += "  b" + std::to_string(b) + ": {mass: 1, inertia: [1, 1, 1]}\n";
  text += "joints:\n";
  for (int a = 0; a < bodies; ++a)
    for (int b = a + 1; b < bodies; ++b) {
      const std::string first = std::to_string(a), second = std::to_string(b);
      text += "  j" + first + "-" + second + ": {between: [b" + first + ", b" + second +
              "], modes: {ball: {kind: ball}}}\n";
    }
  return text;
}

std::string find_loops(const std::string& text) {
  const hil::Scenario scenario = hil::load_scenario_text(text, "run.yaml");
  for (const hil::Finding& finding : hil::list_findings(scenario, *hil::build_simulation(scenario)))
    if (finding.name == "loops") return finding.text;
  return "";
}

TEST(LoopFindings, ManyLoopsThatAreOpenAtOneBodyAreWarnedOf) {
  const std::string text = find_loops(build_knot(12));  // 66 joints, 11 of them the tree
  EXPECT_NE(text.find("of the closed loops, 55 in all, at most "), std::string::npos) << text;
  EXPECT_NE(text.find("times the work of the rest"), std::string::npos) << text;
  EXPECT_EQ(find_loops(build_knot(4)), "");
}

}  // namespace
}  // namespace unlatch::test::loop_finding_test
