// Flexible bodies and their markers in scenarios.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "hil/scenario/flexible/flexible_body.h"
#include "tests/hil/scenario/modes_support.h"
#include "tests/hil/scenario/scenario_support.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"

namespace unlatch::test::scenario_flexible_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kText = R"(unlatch: 1
name: mast
step: {dt: 0.001, until: 1}
bodies:
  bus: {mass: 100, inertia: [10, 10, 10], position: [0, 0, 5]}
  mast:
    flexible: {modes: mast.modes, select: [1, 3], damping: [0.01, 0.02]}
    origin: [1, 2, 3]
    attitude: {rotate: [[z, 1]]}
  mast_root: {marker: {of: mast, at: root}}
)";

// A folder that contains the mast's modes.
class ScenarioFlexible : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("unlatch_flexible_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    modes_ = build_mast_modes(4, 5, Support::kFree);
    std::ofstream(folder_ / "mast.modes") << hil::write_modes_text(modes_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  hil::Scenario load(const std::string& text) {
    std::ofstream(folder_ / "s.yaml") << text;
    return hil::load_scenario((folder_ / "s.yaml").string());
  }
  std::string get_errors(const std::string& what, const std::string& with) {
    try {
      load(replaced(kText, what, with));
      return "";
    } catch (const hil::ScenarioError& error) {
      return error.what();
    }
  }
  std::filesystem::path folder_;
  hil::Modes modes_;
};

TEST_F(ScenarioFlexible, BodiesComeFromTheirFileAndMarkersFromTheBody) {
  const hil::Scenario scenario = load(kText);
  const Body &mast = scenario.model.bodies.at(1), &root = scenario.model.bodies.at(2);
  hil::FlexibleReport report;
  const hil::FlexibleStructure whole = hil::build_flexible_body(modes_, {}, report);
  constexpr double kRoundOff = 1e-12;
  EXPECT_EQ(mast.mass, whole.mass);
  ASSERT_TRUE(mast.flexible);
  EXPECT_EQ(mast.flexible->frequencies, Eigen::Vector2d(whole.flexible.frequencies[0], whole.flexible.frequencies[2]));
  EXPECT_EQ(mast.flexible->damping, Eigen::Vector2d(0.01, 0.02));
  EXPECT_LT((mast.q_WB.conjugate() * (mast.p_WB - Eigen::Vector3d(1, 2, 3)) - whole.centre).norm(), kRoundOff);
  ASSERT_TRUE(root.marker);
  EXPECT_EQ(root.marker->body, 1);
  EXPECT_EQ(root.marker->position, whole.markers[0].marker.position);
  EXPECT_EQ(root.marker->turn.col(1), whole.markers[0].marker.turn.col(2));
}

TEST_F(ScenarioFlexible, ItsTextHoldsTheModesToo) {
  const hil::Scenario scenario = load(kText);
  std::filesystem::remove(folder_ / "mast.modes");
  const hil::Scenario again = hil::load_scenario_text(scenario.text, "recording");
  EXPECT_EQ(again.model.bodies[1].flexible->frequencies, scenario.model.bodies[1].flexible->frequencies);
  EXPECT_EQ(again.text, scenario.text);
}

// The marker's own pose is that of the flexible body and its modes: the model's markers have none before they are
// placed.
TEST_F(ScenarioFlexible, ABodyRelativeToAMarkerStartsFromWhereTheMarkerIs) {
  const std::string ball =
      "  ball: {mass: 1, inertia: [1, 1, 1], relative_to: mast_root, position: [0, 0.5, 0], rate: [0, 1, 0]}\n";
  const std::string moving =
      replaced(kText, "    origin:", "    velocity: [1, 0, 0]\n    rate: [0, 0, 2]\n    origin:");
  const hil::Scenario scenario = load(moving + ball);
  const Model placed = place_markers(scenario.model);
  const Body &root = placed.bodies.at(2), &child = placed.bodies.at(3);
  constexpr double kRoundOff = 1e-12;
  ASSERT_GT(root.p_WB.norm(), 1);
  const Eigen::Vector3d arm = root.q_WB * Eigen::Vector3d(0, 0.5, 0);
  EXPECT_LT((child.p_WB - root.p_WB - arm).norm(), kRoundOff);
  EXPECT_LT((child.v_WB - root.v_WB - (root.q_WB * root.w_WB_B).cross(arm)).norm(), kRoundOff);
  EXPECT_LT((child.w_WB_B - Eigen::Vector3d(0, 1, 2)).norm(), kRoundOff);
  EXPECT_LT(child.q_WB.angularDistance(root.q_WB), kRoundOff);
  // Nor does the order matter in which they are written.
  std::string first = moving;
  first.insert(first.find("  bus:"), ball);
  EXPECT_EQ(load(first).model.bodies.at(0).p_WB, scenario.model.bodies.at(3).p_WB);
  EXPECT_EQ(scenario.model.bodies.at(2).p_WB, Eigen::Vector3d::Zero()) << "the marker itself is as it was";
}

TEST_F(ScenarioFlexible, AMarkerIsRelativeToNothingElseAndNoBodyToItsOwnMarker) {
  EXPECT_THAT(get_errors("at: root}}", "at: root}, relative_to: bus}"),
              HasSubstr("s.yaml:10:58: a marker has its place from its flexible body"));
  EXPECT_THAT(get_errors("    origin: [1, 2, 3]", "    relative_to: mast_root"),
              HasSubstr("relative_to goes round in a circle: mast -> mast_root -> mast"));
}

// A ball falls on the tip of a mast: the blow bends it, and momentum is kept.
TEST_F(ScenarioFlexible, AContactPushesTheMarkerOfAFlexibleBody) {
  const hil::Scenario scenario =
      load(replaced(kText, "step: {dt: 0.001, until: 1}", "step: {dt: 0.001, until: 0.1, contact_substeps: 16}") +
           "  tip: {marker: {of: mast, at: root}, shape: [{sphere: {radius: 0.1}}]}\n"
           "  ball: {mass: 5, inertia: [1, 1, 1], relative_to: tip, position: [0, 0.25, 0], velocity: [0, -2, 0],"
           " shape: [{sphere: {radius: 0.1}}]}\n"
           "contacts: {k: {between: [tip, ball], stiffness: 20 kN/m}}\n");
  Simulation simulation(scenario.model);
  const auto calc_momentum = [&] {
    Vec3 sum{0, 0, 0};
    for (const std::size_t b : {1u, 4u}) sum = sum + scenario.model.bodies[b].mass * simulation.state.bodies[b].v;
    return sum;
  };
  const Vec3 before = calc_momentum();
  int closed = 0;
  double bent = 0;
  for (int tick = 0; tick < 100; ++tick) {
    ASSERT_EQ(simulation.advance().status, StepStatus::kOk);
    closed += get_contact_pairs(simulation.plan, simulation.state, 0)[0].closed != 0 ? 1 : 0;
    for (const double eta : get_modal_coordinates(simulation.plan, simulation.state, 1))
      bent = std::max(bent, std::abs(eta));
  }
  EXPECT_GT(closed, 10);
  EXPECT_LT(closed, 90) << "it has parted again";
  EXPECT_GT(bent, 1e-6);
  constexpr double kKept = 1e-9;  // of the momentum: the frame moves with the centre of mass
  EXPECT_LT(norm(calc_momentum() - before), kKept * norm(before));
  EXPECT_GT(get_contact_totals(simulation.plan, simulation.state, 0).impulse, 1);
}

TEST_F(ScenarioFlexible, ModesThatWereChangedWhenTheyWereReadAreReported) {
  EXPECT_TRUE(load(kText).remarks.empty());
  modes_.points.back().mass *= 1.2;  // the modes belong to other masses
  std::ofstream(folder_ / "mast.modes") << hil::write_modes_text(modes_);
  const hil::Scenario scenario = load(kText);
  ASSERT_EQ(scenario.remarks.size(), 1u);
  EXPECT_EQ(scenario.remarks[0].kind, "modes");
  EXPECT_EQ(scenario.remarks[0].where, "body 'mast'");
  EXPECT_THAT(scenario.remarks[0].text, HasSubstr("changed when the file was read"));
}

TEST_F(ScenarioFlexible, MistakesAreNamed) {
  EXPECT_THAT(get_errors("mast.modes", "nothing.modes"), HasSubstr("s.yaml:7:23: its modes cannot be read"));
  EXPECT_THAT(get_errors("[1, 3]", "[1, 9]"), HasSubstr("the file has no elastic mode 9"));
  EXPECT_THAT(get_errors("[0.01, 0.02]", "[0.01]"), ::testing::Not(HasSubstr("damping ratios")));
  EXPECT_THAT(get_errors("[0.01, 0.02]", "[0.1, 0.1, 0.1]"), HasSubstr("3 damping ratios for 2 modes"));
  EXPECT_THAT(get_errors("[1, 3]", "first"), HasSubstr("s.yaml:7:43: "));
  EXPECT_THAT(get_errors("[1, 3]", "[1, 2.5]"), HasSubstr("s.yaml:7:43: the number of a mode is a whole one"));
  EXPECT_THAT(get_errors("[1, 3]", "[1, 1e300]"), HasSubstr("the number of a mode is a whole one"));
  EXPECT_THAT(get_errors("at: root", "at: rooot"), HasSubstr("root"));
  EXPECT_THAT(get_errors("of: mast", "of: bus"), HasSubstr("s.yaml"));
  std::ofstream(folder_ / "mast.modes") << "unlatch modes 1\n";
  EXPECT_THAT(get_errors("mast.modes", "mast.modes"), HasSubstr("mast.modes:2:1: the file ends too early"));
}

}  // namespace
}  // namespace unlatch::test::scenario_flexible_test
