// Flexible bodies and their markers in scenarios.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "hil/flexible/flexible_body.h"
#include "tests/hil/modes_support.h"
#include "tests/hil/scenario_support.h"

namespace unlatch::test {
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

TEST_F(ScenarioFlexible, ModesThatWereChangedWhenTheyWereReadAreTold) {
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
}  // namespace unlatch::test
