// Notices of pushers and of friction that the step does not resolve.
#include <cmath>
#include <optional>
#include <string>

#include "hil/run/findings/findings.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::friction_notice_test {
namespace {

std::optional<hil::RunNotice> find_notice(const AnalysedRun& run, const std::string& name, const std::string& subject) {
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == name && notice.subject == subject) return notice;
  return std::nullopt;
}

std::string find_forecast(const std::string& text, const std::string& name, const std::string& where) {
  const hil::Scenario scenario = hil::load_scenario_text(text, "run.yaml");
  for (const hil::Finding& finding : hil::list_findings(scenario, *hil::build_simulation(scenario)))
    if (finding.name == name && finding.where == where) return finding.text;
  return "";
}

double read_number_before(const std::string& text, const std::string& what) {
  const std::size_t end = text.find(what), begin = text.rfind(' ', end - 1);
  return std::stod(text.substr(begin + 1));
}

// A block of 4 kg, pressed on a rail with 100 N, slides along x with `speed`: mobility 1/4 per kg.
std::string build_slider(const std::string& friction, double speed = 0) {
  return R"(unlatch: 1
name: slider
step: {dt: 1 ms, until: 0.02}
gravity: {uniform: [0, 0, -25]}
bodies:
  block: {mass: 4, inertia: [1, 1, 1], velocity: [)" +
         std::to_string(speed) + R"(, 0, 0]}
joints:
  rail: {between: [ground, block], modes: {slide: {kind: prismatic, axis: x}}}
elements:
  drag: {type: joint_friction, joint: rail, axis: x, )" +
         friction + "}\n";
}

// 0.3 · 100 N / 1 mm/s / 4 kg = 7500 1/s while it sticks.
TEST(FrictionNotices, AJointsFrictionThatSticksFasterThanTheStepResolvesIsReported) {
  const std::string text = build_slider("coefficient: 0.3, speed: 1 mm/s");
  const AnalysedRun run(text);
  const std::optional<hil::RunNotice> notice = find_notice(run, "friction", "drag");
  ASSERT_TRUE(notice.has_value());
  EXPECT_EQ(notice->time, 0);
  EXPECT_NEAR(read_number_before(notice->text, ": beyond what is stable"), 7.5, 0.01);
  EXPECT_NE(notice->text.find("a step of 2.65e-05 s would do"), std::string::npos) << notice->text;
  EXPECT_NE(find_forecast(text, "friction", "element 'drag'"), "");
  const std::string resolved = build_slider("coefficient: 0.3, speed: 5 cm/s");  // 150 1/s
  EXPECT_FALSE(find_notice(AnalysedRun(resolved), "friction", "drag").has_value());
  EXPECT_EQ(find_forecast(resolved, "friction", "element 'drag'"), "");
}

// Sliding with 2 m/s, friction changes the speed slowly: 3.75 1/s.
TEST(FrictionNotices, AJointThatOnlySlidesIsNotReported) {
  const std::string text = build_slider("coefficient: 0.3, speed: 1 mm/s", 2);
  EXPECT_FALSE(find_notice(AnalysedRun(text), "friction", "drag").has_value());
  EXPECT_EQ(find_forecast(text, "friction", "element 'drag'"), "");
}

// 30 N decelerate it by 7.5 m/s²: it sticks after 0.0133 s, after which the notice has its time.
TEST(FrictionNotices, AJointThatComesToStickIsReportedThen) {
  const AnalysedRun run(build_slider("coefficient: 0.3, speed: 1 mm/s", 0.1));
  const std::optional<hil::RunNotice> notice = find_notice(run, "friction", "drag");
  ASSERT_TRUE(notice.has_value());
  EXPECT_GT(notice->time, 0.005);
  EXPECT_LT(notice->time, 0.0133 + 0.001);
}

// About an axis the lever counts twice: μ |R| r² / v_s / I with 0.5 · 100 N · (0.2 m)² / 1 mm/s / 1 kg m² = 2000 1/s.
TEST(FrictionNotices, APinsRadiusCountsTwice) {
  const std::string text = R"(unlatch: 1
name: pin
step: {dt: 1 ms, until: 0.01}
gravity: {uniform: [0, 0, -25]}
bodies:
  wheel: {mass: 4, inertia: [1, 1, 1]}
joints:
  pin: {between: [ground, wheel], modes: {turn: {kind: revolute, axis: z}}}
elements:
  bearing: {type: joint_friction, joint: pin, axis: rot_z, coefficient: 0.5, radius: 0.2, speed: 1 mm/s}
)";
  const AnalysedRun run(text);
  ASSERT_TRUE(find_notice(run, "friction", "bearing").has_value());
  EXPECT_NEAR(read_number_before(find_notice(run, "friction", "bearing")->text, ": not resolved"), 2, 0.01);
}

// Two bodies of 2 kg: mobility 1 per kg.
std::string build_pusher(const std::string& law) {
  return R"(unlatch: 1
name: pushed
step: {dt: 1 ms, until: 0.02}
bodies:
  lower: {mass: 2, inertia: [1, 1, 1]}
  upper: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0]}
elements:
  push: {type: pusher, between: [lower, upper], stroke: 5 cm, )" +
         law + "}\n";
}

TEST(FrictionNotices, AStiffPusherIsReported) {
  const std::string stiff = build_pusher("preload: 50 kN, stiffness: 1 MN/m");  // √(1e6 · 1) · 1 ms
  const AnalysedRun run(stiff);
  ASSERT_TRUE(find_notice(run, "spring", "push").has_value());
  EXPECT_NE(find_notice(run, "spring", "push")->text.find("dt·omega 1:"), std::string::npos);
  EXPECT_NE(find_forecast(stiff, "step", "element 'push'"), "");
  const std::string soft = build_pusher("preload: 100 N, stiffness: 1 kN/m");
  EXPECT_FALSE(find_notice(AnalysedRun(soft), "spring", "push").has_value());
  EXPECT_EQ(find_forecast(soft, "step", "element 'push'"), "");
}

// 5 N / 1 mm/s · 1/kg = 5000 1/s at the start from rest; 5 N / 5 cm/s · 1/kg = 100 1/s.
TEST(FrictionNotices, APushersFrictionIsReported) {
  const std::string text = build_pusher("preload: 100 N, stiffness: 1 kN/m, friction: 5 N, friction_speed: 1 mm/s");
  const AnalysedRun run(text);
  ASSERT_TRUE(find_notice(run, "friction", "push").has_value());
  EXPECT_NEAR(read_number_before(find_notice(run, "friction", "push")->text, ": beyond what is stable"), 5, 0.01);
  EXPECT_NE(find_forecast(text, "friction", "element 'push'"), "");
  const std::string soft = build_pusher("preload: 100 N, stiffness: 1 kN/m, friction: 5 N, friction_speed: 5 cm/s");
  EXPECT_FALSE(find_notice(AnalysedRun(soft), "friction", "push").has_value());
}

}  // namespace
}  // namespace unlatch::test::friction_notice_test
