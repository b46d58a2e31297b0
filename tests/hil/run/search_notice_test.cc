// Notices of searches for events within a step that reach a bound on their work.
#include <string>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::search_notice_test {
namespace {

// A bolt holds a motor whose thrust jumps within the first step of 10 ms. Beside the jump the reaction rises slowly.
std::string build_ignition(const std::string& times, const std::string& thrusts, const std::string& breaks_at) {
  return R"(unlatch: 1
name: ignition
step: {dt: 10 ms, until: 30 ms}
bodies:
  block: {mass: 4, inertia: [1, 1, 1]}
joints:
  bolt: {between: [ground, block], mode: tied, modes: {tied: {kind: weld}, free: {kind: free}}}
elements:
  motor: {type: force, body: block, point: [0, 0, 0], direction: [1, 0, 0], profile: {table: {times: )" +
         times + ", values: " + thrusts + R"(}}}
events:
  - {name: breaks, when: {reaction_force: bolt, above: )" +
         breaks_at + "}, then: [{set_mode: {joint: bolt, mode: free}}]}\n";
}

// Iterations converge slowly to a jump: half of them are attracted by the flat part beside it.
TEST(SearchNotices, AnInstantThatTheTriesDoNotLocateIsReported) {
  // The step is split at the first eight points, and no more at the jump.
  const AnalysedRun run(
      build_ignition("[0, 0.4 ms, 0.8 ms, 1.2 ms, 1.6 ms, 2 ms, 2.4 ms, 2.8 ms, 3.2 ms, 4 ms, 4.01 ms, 30 ms]",
                     "[0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.999, 20 kN, 22 kN]", "2 N"));
  EXPECT_EQ(run.analysis.search.unlocated, 1);
  EXPECT_EQ(run.analysis.search.postponed, 0);
  const std::vector<hil::RunNotice> notices = list_searches(run);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_EQ(notices[0].subject, "breaks");
  EXPECT_EQ(notices[0].time, 0.01);
  EXPECT_NE(notices[0].text.find("its instant is known to "), std::string::npos) << notices[0].text;
  ASSERT_EQ(run.analysis.timeline.size(), 1u);
  EXPECT_NEAR(run.analysis.timeline[0].time, 0.004, 1e-6);
}

// The jump to 100 kN attracts the parabola to 52 us before it, where the bolt carries 0.95 N.
TEST(SearchNotices, AThresholdInAJumpIsNotTakenForCrossedBesideIt) {
  const AnalysedRun run(build_ignition("[0, 3.1 ms, 3.100001 ms, 30 ms]", "[0.5, 1, 100 kN, 110 kN]", "10 N"));
  EXPECT_EQ(run.analysis.search.unlocated, 0);
  EXPECT_TRUE(list_searches(run).empty());
  ASSERT_EQ(run.analysis.timeline.size(), 1u);
  EXPECT_NEAR(run.analysis.timeline[0].time, 0.0031, 2e-8);
}

// A block begins to slide from rest with 10 m/s², 5 cm in the first step.
std::string build_slider(const std::string& events) {
  return R"(unlatch: 1
name: slider
step: {dt: 0.1, until: 0.3}
gravity: {uniform: [10, 0, 0]}
bodies:
  block: {mass: 4, inertia: [1, 1, 1]}
joints:
  rail: {between: [ground, block], modes: {slide: {kind: prismatic, axis: x}}}
signals: [there]
events:
)" + events;
}

std::string pass(const std::string& name, const std::string& place) {
  return "  - {name: " + name + ", when: {displacement: {joint: rail, axis: x}, above: " + place +
         "}, then: [{raise: there}]}\n";
}

// A threshold that it passes just after rest: after a part of 1e-4 of the step's time, of 1e-8 of its path.
TEST(SearchNotices, AnInstantThatIsLocatedIsNot) {
  const AnalysedRun run(build_slider(pass("early", "5e-10")));
  EXPECT_EQ(run.analysis.search.unlocated, 0);
  EXPECT_TRUE(list_searches(run).empty());
  ASSERT_EQ(run.analysis.timeline.size(), 1u);
  EXPECT_NEAR(run.analysis.timeline[0].time, 1e-5, 1e-7);
}

TEST(SearchNotices, MoreInstantsThanAStepHasAreReported) {
  std::string events;
  for (int k = 1; k <= 12; ++k) events += pass("e" + std::to_string(k), std::to_string(0.06 + 0.01 * k));
  const AnalysedRun run(build_slider(events));  // from 5 to 20 cm in the second step
  EXPECT_EQ(run.analysis.search.postponed, 4);
  EXPECT_EQ(run.analysis.timeline.size(), 12u);
  const std::vector<hil::RunNotice> notices = list_searches(run);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_NE(notices[0].text.find("more instants with events than its 8"), std::string::npos) << notices[0].text;
}

constexpr const char* kFarShape = ", {sphere: {radius: 0.1, centre: [0, -50, 0]}}";

// Balls that pass a post within one step, each at a slightly different distance. `other_shapes`: further shapes of the
// post.
std::string build_passing(int balls, double hair, const std::string& other_shapes = "") {
  std::string text = R"(unlatch: 1
name: passing
step: {dt: 1 ms, until: 3 ms}
bodies:
  post: {mass: 1000, inertia: [100, 100, 100], shape: [{sphere: {radius: 0.1}})" +
                     other_shapes + "]}\n";
  std::string contacts = "contacts:\n";
  for (int k = 0; k < balls; ++k) {
    const std::string name = "ball" + std::to_string(k);
    text += "  " + name + ": {mass: 1, inertia: [1, 1, 1], position: [" + std::to_string(-0.6 - 0.01 * k) + ", " +
            std::to_string(0.2 + hair) + ", 0], velocity: [400, 0, 0], shape: [{sphere: {radius: 0.1}}]}\n";
    contacts += "  hit" + std::to_string(k) + ": {between: [post, " + name + "], stiffness: 1 kN/m}\n";
  }
  return text + contacts;
}

TEST(SearchNotices, LooksForTouchesThatRunOutAreReported) {
  const AnalysedRun run(build_passing(6, 1e-5));
  EXPECT_GT(run.analysis.search.unseen, 0);
  const std::vector<hil::RunNotice> notices = list_searches(run);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_EQ(notices[0].subject.substr(0, 3), "hit");
  EXPECT_NE(notices[0].text.find("it may have touched and parted again within a step, up to "), std::string::npos)
      << notices[0].text;
}

// A contact has a pair of shapes for each shape of the post: pairs are not numbered as contacts are.
TEST(SearchNotices, TheContactOfAUnionOfShapesIsTheOneThatIsReported) {
  const AnalysedRun one(build_passing(6, 1e-5)), united(build_passing(6, 1e-5, kFarShape));
  EXPECT_EQ(united.analysis.search.unseen, one.analysis.search.unseen);
  const std::vector<hil::RunNotice> expected = list_searches(one), notices = list_searches(united);
  ASSERT_EQ(expected.size(), 1u);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_EQ(notices[0].subject, expected[0].subject);
}

TEST(SearchNotices, ABallThatPassesClearlyIsNot) {
  const AnalysedRun run(build_passing(1, 1e-2));
  EXPECT_EQ(run.analysis.search.unseen, 0);
  EXPECT_TRUE(list_searches(run).empty());
}

}  // namespace
}  // namespace unlatch::test::search_notice_test
