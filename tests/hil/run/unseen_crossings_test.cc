// What a quantity does within a step: conditions of events that hold for a part of it alone, and forces that engage for
// a part of it, so that no tick shows them; the least size of a vector.
#include "hil/run/audit/unseen_crossings.h"

#include <cmath>
#include <string>
#include <vector>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::unseen_crossings_test {
namespace {

// A slider on a spring: x = 1 m - cos(20/s t) m. At its peaks it is beyond 1.9995 m for 3.2 ms.
std::string build_swing(const std::string& dt, const std::string& condition, const std::string& more = "") {
  return "unlatch: 1\nname: swing\nstep: {dt: " + dt + R"(, until: 0.3}
bodies:
  slider: {mass: 1, inertia: [1, 1, 1]}
joints:
  rail: {between: [ground, slider], modes: {slides: {kind: prismatic, axis: x}}}
elements:
  spring: {type: joint_spring, joint: rail, axis: x, stiffness: 400, rest: 1 m}
  buffer: {type: pusher, between: [ground, slider], guide: [-1, 0, 0], stroke: 10 cm, preload: 0, stiffness: 0}
quantities:
  x: {position: {body: slider, component: x}}
  square: {expression: "x * x", unit: m2}
signals: [far]
channels:
  go: {initial: 0, range: [0, 1], safe: 0}
events:
  - {name: hit, when: )" +
         condition + ", then: [{raise: far}]" + more + R"(}
requirements:
  - {id: end, displacement: {joint: rail, axis: x}, take: final, at_most: 3 m}
)";
}

// The step that the notice proposes, s.
std::string find_proposed_step(const std::string& text) {
  const std::string before = "a step of ";
  const std::size_t from = text.find(before) + before.size();
  return text.substr(from, text.find(" s ", from) - from) + " s";
}

TEST(UnseenCrossings, AConditionThatHoldsForAPartOfAStepIsUnresolvedAndTheProposedStepSeesIt) {
  const std::string conditions[] = {
      "{displacement: {joint: rail, axis: x}, above: 1.9995 m}",
      "{quantity: x, above: 1.9995 m}",
      "{quantity: square, above: 3.99800025 m2}",
      "{quantity: {position: {body: slider}}, above: 1.9995 m}",
      "{all: [{quantity: x, above: 1.9995 m}, {time: 1 ms}]}",
      "{any: [{quantity: x, above: 1.9995 m}, {quantity: x, below: -1 m}]}",
      "{not: {quantity: x, below: 1.9995 m}}",
      "{any: [{quantity: x, above: 1.9995 m}, {command: go, above: 0.5}]}",
      "{all: [{quantity: x, above: 1.9995 m}, {command: go, below: 0.5}]}",
  };
  const double first = std::acos(-0.9995) / 20;  // s
  for (const std::string& condition : conditions) {
    const AnalysedRun run(build_swing("10 ms", condition));
    EXPECT_TRUE(run.analysis.timeline.empty()) << condition;
    const std::vector<hil::RunNotice> notices = list_searches(run);
    ASSERT_EQ(notices.size(), 1u) << condition;
    EXPECT_EQ(notices[0].subject, "hit");
    EXPECT_TRUE(notices[0].unresolved);
    EXPECT_FALSE(run.judge("end").unresolved.empty());
    const AnalysedRun fine(build_swing(find_proposed_step(notices[0].text), condition));
    EXPECT_TRUE(list_searches(fine).empty()) << condition;
    ASSERT_FALSE(fine.analysis.timeline.empty()) << notices[0].text;
    EXPECT_NEAR(fine.analysis.timeline[0].time, first, 1e-6) << condition;
    EXPECT_TRUE(fine.judge("end").unresolved.empty()) << fine.judge("end").unresolved;
  }
}

TEST(UnseenCrossings, ASpanOfTimeWithinAStepIsUnresolvedAndTheProposedStepSeesIt) {
  const std::string spans[] = {
      "{all: [{time: 121 ms}, {not: {time: 124 ms}}]}",
      "{not: {any: [{time: 124 ms}, {not: {time: 121 ms}}]}}",
      "{all: [{time: 121 ms}, {not: {time: 124 ms}}, {command: go, below: 0.5}]}",
  };
  for (const std::string& span : spans) {
    const AnalysedRun run(build_swing("10 ms", span));
    EXPECT_TRUE(run.analysis.timeline.empty()) << span;
    ASSERT_EQ(list_searches(run).size(), 1u) << span;
    EXPECT_NE(list_searches(run)[0].text.find("at 0.121000 s, and false again 0.003 s later"), std::string::npos)
        << list_searches(run)[0].text;
    EXPECT_FALSE(run.judge("end").unresolved.empty());
    const AnalysedRun fine(build_swing(find_proposed_step(list_searches(run)[0].text), span));
    EXPECT_TRUE(list_searches(fine).empty()) << span;
    ASSERT_EQ(fine.analysis.timeline.size(), 1u) << span;
    EXPECT_NEAR(fine.analysis.timeline[0].time, 0.121, 1e-9) << span;
  }
  const std::string seen[] = {
      "{all: [{time: 121 ms}, {not: {time: 131 ms}}]}",
      "{any: [{time: 121 ms}, {time: 125 ms}]}",
      "{all: [{time: 121 ms}, {not: {time: 124 ms}}, {command: go, above: 0.5}]}",
  };
  for (const std::string& span : seen)
    EXPECT_TRUE(list_searches(AnalysedRun(build_swing("10 ms", span))).empty()) << span;
}

TEST(UnseenCrossings, AConditionThatAnEventSawOrDidNotWaitForIsNotTaken) {
  const std::string seen[] = {
      build_swing("10 ms", "{quantity: x, above: 1.9 m}"),     // for 45 ms
      build_swing("10 ms", "{quantity: x, above: 2.0001 m}"),  // never
      build_swing("10 ms", "{all: [{quantity: x, above: 1.9995 m}, {signal: far}]}"),
      build_swing("10 ms", "{all: [{quantity: x, above: 1.9995 m}, {command: go, above: 0.5}]}"),
      build_swing("10 ms", "{quantity: x, above: 1 m}"),  // it acted before
      build_swing("10 ms", "{quantity: x, above: 1 m}", ", repeat: true"),
  };
  for (const std::string& text : seen) {
    const AnalysedRun run(text);
    EXPECT_TRUE(list_searches(run).empty()) << text << list_searches(run)[0].text;
    EXPECT_TRUE(run.judge("end").unresolved.empty()) << run.judge("end").unresolved;
  }
}

TEST(UnseenCrossings, AConditionThatReadsWhatNoTickHasIsReportedAsNotSearched) {
  const std::string missing[] = {
      "{force: buffer, above: 1 kN}",
      "{all: [{quantity: x, above: 1.9995 m}, {force: buffer, below: 1 kN}]}",
  };
  for (const std::string& condition : missing) {
    const AnalysedRun run(build_swing("10 ms", condition));
    ASSERT_EQ(list_searches(run).size(), 1u) << condition;
    EXPECT_EQ(list_searches(run)[0].subject, "hit");
    EXPECT_NE(list_searches(run)[0].text.find("it reads force of buffer"), std::string::npos)
        << list_searches(run)[0].text;
    EXPECT_FALSE(list_searches(run)[0].unresolved);
    EXPECT_TRUE(run.judge("end").unresolved.empty());
  }
  // Nothing of it may come and go between ticks.
  EXPECT_TRUE(
      list_searches(AnalysedRun(build_swing("10 ms", "{any: [{command: go, above: 0.5}, {time: 1}]}"))).empty());
}

// A flap turns as 5 rad − 5 rad cos(20/s t). The analysis begins at 0.1 s, as after a checkpoint, behind a whole turn.
TEST(UnseenCrossings, TurnsOfAnAngleAreCountedFromTheBeginningOfItsJoint) {
  const hil::Scenario scenario = hil::load_scenario_text(R"(unlatch: 1
name: turns
step: {dt: 10 ms, until: 0.3}
bodies:
  flap: {mass: 1, inertia: [1, 1, 1]}
joints:
  hinge: {between: [ground, flap], modes: {turns: {kind: revolute, axis: z}}}
elements:
  spring: {type: joint_spring, joint: hinge, axis: rot_z, stiffness: 400, rest: 5 rad}
signals: [far]
events:
  - {name: hit, when: {angle: {joint: hinge, axis: z}, above: 9.9975 rad}, then: [{raise: far}]}
)",
                                                         "turns.yaml");
  const auto simulation = hil::build_simulation(scenario);
  while (simulation->get_tick() < 10) ASSERT_EQ(simulation->step().status, StepStatus::kOk);
  hil::RunAnalysis analysis(scenario, *simulation);
  analysis.update(StepReport{});
  while (simulation->get_tick() < 30) analysis.update(simulation->step());
  std::vector<std::string> found;
  for (const hil::RunNotice& notice : analysis.accuracy().get())
    if (notice.name == "search") found.push_back(notice.text);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("at 0.156"), std::string::npos) << found[0];  // it is greatest at π/20 s
}

// The slider of build_swing(), and an element that is within reach for 3.2 ms about a place where the slider returns.
std::string build_engagement(const std::string& dt, const std::string& element) {
  return "unlatch: 1\nname: engaged\nstep: {dt: " + dt + R"(, until: 0.35}
bodies:
  slider: {mass: 1, inertia: [1, 1, 1]}
  other: {mass: 1, inertia: [1, 1, 1]}
joints:
  rail: {between: [ground, slider], modes: {slides: {kind: prismatic, axis: x}}}
elements:
  spring: {type: joint_spring, joint: rail, axis: x, stiffness: 400, rest: 1 m}
)" + (element.starts_with("{joint") ? "stops:\n  reach: " : "  reach: ") +
         element + R"(
requirements:
  - {id: end, displacement: {joint: rail, axis: x}, take: final, at_most: 3 m}
  - {id: apart, position: {body: other}, take: final, at_most: 3 m}
)";
}

struct Engagement {
  std::string element, event;
  std::size_t before;  // events of the element before
  double due;          // s
};

std::vector<Engagement> list_engagements() {
  const double turn = std::acos(-1.0) / 10, edge = std::acos(0.9995) / 20;  // s: period; from a turning point to 0.5 mm
  const std::string rail = "between: [ground, slider], ";
  return {
      {"{joint: rail, axis: x, at_most: 1.9995 m, stiffness: 1 N/m}", "touch", 0, turn / 2 - edge},
      {"{type: cord, " + rail + "length: 1.9995 m, stiffness: 1 N/m, damping: 0.1 N s/m}", "taut", 0, turn / 2 - edge},
      {"{type: cord, " + rail + "length: 0.0005 m, stiffness: 1e-6 N/m}", "slack", 1, turn - edge},
      {"{type: pusher, " + rail + "guide: [1, 0, 0], stroke: 0.5 mm, preload: 1e-6 N}", "touch", 1, turn - edge},
      {"{joint: rail, axis: x, at_least: 0.0005 m, stiffness: 1e-6 N/m}", "touch", 1, turn - edge},
  };
}

TEST(UnseenEngagements, AForceThatEngagesAndPartsWithinAStepIsUnresolvedAndTheProposedStepSeesIt) {
  for (const Engagement& one : list_engagements()) {
    const AnalysedRun run(build_engagement("10 ms", one.element));
    EXPECT_EQ(run.analysis.timeline.size(), one.before) << one.element;
    const std::vector<hil::RunNotice> notices = list_searches(run);
    ASSERT_EQ(notices.size(), 1u) << one.element;
    EXPECT_EQ(notices[0].subject, "reach");
    EXPECT_TRUE(notices[0].unresolved);
    EXPECT_NE(notices[0].text.find("its event " + one.event + " was due within a step"), std::string::npos)
        << notices[0].text;
    EXPECT_FALSE(run.judge("end").unresolved.empty()) << one.element;
    EXPECT_TRUE(run.judge("apart").unresolved.empty()) << run.judge("apart").unresolved;
    const AnalysedRun fine(build_engagement(find_proposed_step(notices[0].text), one.element));
    EXPECT_TRUE(list_searches(fine).empty()) << one.element << list_searches(fine)[0].text;
    ASSERT_EQ(fine.analysis.timeline.size(), one.before + 2) << notices[0].text;
    EXPECT_EQ(fine.analysis.timeline[one.before].name, one.event);
    EXPECT_NEAR(fine.analysis.timeline[one.before].time, one.due, 1e-5) << one.element;
    EXPECT_TRUE(fine.judge("end").unresolved.empty()) << fine.judge("end").unresolved;
  }
}

TEST(UnseenEngagements, AForceThatEngagesAtATickOrNeverOrIsOffIsNotTaken) {
  const std::string resolved[] = {
      "{joint: rail, axis: x, at_most: 1.9 m, stiffness: 1 N/m}",
      "{joint: rail, axis: x, at_most: 2.0001 m, stiffness: 1 N/m}",
      "{joint: rail, axis: x, at_most: 1.9995 m, stiffness: 1 N/m, enabled: false}",
      "{type: cord, between: [ground, slider], length: 1.9 m, stiffness: 1 kN/m}",
      "{type: cord, between: [ground, slider], length: 2.0001 m, stiffness: 1 kN/m}",
      "{type: pusher, between: [ground, slider], guide: [1, 0, 0], stroke: 0.1 m, preload: 1 N}",
  };
  for (const std::string& element : resolved) {
    const AnalysedRun run(build_engagement("10 ms", element));
    EXPECT_TRUE(list_searches(run).empty()) << element << list_searches(run)[0].text;
    EXPECT_TRUE(run.judge("end").unresolved.empty()) << run.judge("end").unresolved;
  }
}

// A flap on a spring: 1 rad − cos(20/s t) rad, as the slider of build_swing().
std::string build_flap(const std::string& dt, const std::string& stop) {
  return "unlatch: 1\nname: flap\nstep: {dt: " + dt + R"(, until: 0.35}
bodies:
  flap: {mass: 1, inertia: [1, 1, 1]}
joints:
  hinge: {between: [ground, flap], modes: {turns: {kind: revolute, axis: z}}}
elements:
  spring: {type: joint_spring, joint: hinge, axis: rot_z, stiffness: 400, rest: 1 rad}
stops:
  reach: )" +
         stop + R"(
requirements:
  - {id: end, angle: {joint: hinge, axis: z}, take: final, at_most: 3 rad}
)";
}

TEST(UnseenEngagements, AnAngularStopThatIsHitWithinAStepIsUnresolvedAndTheProposedStepSeesIt) {
  const double turn = std::acos(-1.0) / 10, edge = std::acos(0.9995) / 20;  // s, as above
  const Engagement stops[] = {
      {"{joint: hinge, axis: rot_z, at_most: 1.9995 rad, stiffness: 1 N m/rad}", "touch", 0, turn / 2 - edge},
      {"{joint: hinge, axis: rot_z, at_least: 0.0005 rad, stiffness: 1e-6 N m/rad}", "touch", 1, turn - edge},
  };
  for (const Engagement& one : stops) {
    const AnalysedRun run(build_flap("10 ms", one.element));
    EXPECT_EQ(run.analysis.timeline.size(), one.before) << one.element;
    const std::vector<hil::RunNotice> notices = list_searches(run);
    ASSERT_EQ(notices.size(), 1u) << one.element;
    EXPECT_TRUE(notices[0].unresolved);
    EXPECT_FALSE(run.judge("end").unresolved.empty()) << one.element;
    const AnalysedRun fine(build_flap(find_proposed_step(notices[0].text), one.element));
    EXPECT_TRUE(list_searches(fine).empty()) << one.element;
    ASSERT_EQ(fine.analysis.timeline.size(), one.before + 2) << notices[0].text;
    EXPECT_EQ(fine.analysis.timeline[one.before].name, one.event);
    EXPECT_NEAR(fine.analysis.timeline[one.before].time, one.due, 1e-5) << one.element;
  }
  EXPECT_TRUE(list_searches(AnalysedRun(build_flap(
                                "10 ms", "{joint: hinge, axis: rot_z, at_most: 2.0001 rad, stiffness: 1 N m/rad}")))
                  .empty());
}

// The slider's point is on the line that touches the drum where the cord leaves it, a quarter turn from its anchor.
std::string build_drum_cord(double straight) {
  return "{type: cord, between: [ground, slider], length: " + std::to_string(straight + 0.025 * std::acos(-1.0)) +
         " m, wraps: {centre: [-0.1, -0.05, 0], axis: [0, 0, 1], radius: 0.05, sense: left, wound: 90 deg}, stiffness: "
         "1 "
         "N/m}";
}

// Notices about the element; what reads how far it is wound is not searched.
std::vector<hil::RunNotice> list_reaches(const AnalysedRun& run) {
  std::vector<hil::RunNotice> found = list_searches(run);
  std::erase_if(found, [](const hil::RunNotice& notice) { return notice.subject != "reach"; });
  return found;
}

TEST(UnseenEngagements, ACordOnADrumThatIsTautWithinAStepIsUnresolvedAndTheProposedStepSeesIt) {
  const double due = std::acos(-1.0) / 20 - std::acos(0.9995) / 20;  // s, beyond 1.9995 m
  const AnalysedRun run(build_engagement("10 ms", build_drum_cord(2.0995)));
  const std::vector<hil::RunNotice> notices = list_reaches(run);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_NE(notices[0].text.find("its event taut was due within a step"), std::string::npos) << notices[0].text;
  EXPECT_FALSE(run.judge("end").unresolved.empty());
  const AnalysedRun fine(build_engagement(find_proposed_step(notices[0].text), build_drum_cord(2.0995)));
  EXPECT_TRUE(list_reaches(fine).empty());
  ASSERT_FALSE(fine.analysis.timeline.empty());
  EXPECT_EQ(fine.analysis.timeline[0].name, "taut");
  EXPECT_NEAR(fine.analysis.timeline[0].time, due, 1e-5);
  EXPECT_TRUE(list_reaches(AnalysedRun(build_engagement("10 ms", build_drum_cord(2.1001)))).empty());
}

// Two balls that pass each other at 2 m/s, nearer than 1 mm for 1 ms: their distance has a corner there.
TEST(UnseenCrossings, APassThatNoTickShowsIsUnresolvedByTheSizeOfAVector) {
  const auto build = [](const std::string& near) {
    return R"(unlatch: 1
name: pass
step: {dt: 10 ms, until: 0.5}
bodies:
  a: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}
  b: {mass: 1, inertia: [1, 1, 1], position: [0.503, 0.1 mm, 0], velocity: [-1, 0, 0]}
events:
  - {name: near, when: {quantity: {position: {body: a, relative_to: b}}, below: )" +
           near + R"(}, then: []}
requirements:
  - {id: end, position: {body: a, along: [1, 0, 0]}, take: final, at_most: 3 m}
)";
  };
  const AnalysedRun run(build("1 mm"));
  ASSERT_EQ(list_searches(run).size(), 1u);
  EXPECT_NE(list_searches(run)[0].text.find("at 0.251"), std::string::npos) << list_searches(run)[0].text;
  EXPECT_FALSE(run.judge("end").unresolved.empty());
  EXPECT_TRUE(list_searches(AnalysedRun(build("0.05 mm"))).empty());
}

// It passes a ball at 0.25 m within a step of 50 ms, 13 mm behind a tick. The size has all but a corner there.
TEST(Requirements, TheLeastSizeOfAVectorWithinAStepIsThatOfItsSquare) {
  const AnalysedRun run(R"(unlatch: 1
name: pass
step: {dt: 50 ms, until: 1}
bodies:
  a: {mass: 1, inertia: [1, 1, 1]}
  b: {mass: 1, inertia: [1, 1, 1], position: [-5.013, 0.25, 0], velocity: [10, 0, 0]}
requirements:
  - {id: apart, quantity: {position: {body: b, relative_to: a}}, take: minimum, at_least: 0.2 m}
)");
  EXPECT_NEAR(run.judge("apart").value, 0.25, 1e-9);
  EXPECT_NEAR(run.judge("apart").time, 0.5013, 1e-6);
}

}  // namespace
}  // namespace unlatch::test::unseen_crossings_test
