// Forces that depend on the motion that they cause: steps that do not resolve such a feedback, where their halves end
// at the same knots of a table and make the same error; and what of it a verdict says.
#include "hil/run/notices/feedback_audit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::feedback_audit_test {
namespace {

// A body of 1 kg and 1 m/s, which a table over its speed brakes by 5 N up to 0.5 m/s and 205 N at 1 m/s.
std::string brake(const std::string& dt) {
  return "unlatch: 1\nname: brake\nstep: {dt: " + dt + R"yaml(, until: 0.1}
bodies: {b: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}}
tables: {drag: {axes: {v: {at: [0.5, 1.0], unit: m/s}}, values: [-5, -205], unit: N, interpolation: linear}}
quantities: {vx: {velocity: {body: b, component: x}}}
elements: {f: {type: force, body: b, frame: world, direction: [1, 0, 0], profile: {expression: "drag(vx)"}}}
requirements:
  - {id: v, velocity: {body: b, component: x}, take: final, range: [-9, 9]}
  - {id: x, position: {body: b, component: x}, take: final, range: [-9, 9]}
)yaml";
}

// At 400/s it falls by 5/400 m/s less than to 0.5 m/s, and from there by 5 m/s².
double find_speed(double time) { return 0.5 - 5 * (time - std::log(41.0) / 400); }

// The step that a notice says is enough, s.
double find_step(const std::string& text) {
  double step = 0;
  const std::size_t at = text.find("; a step of ");
  EXPECT_NE(at, std::string::npos) << text;
  if (at == std::string::npos) return 0;
  EXPECT_EQ(std::sscanf(text.c_str() + at, "; a step of %lf s", &step), 1);
  return step;
}

// With 4 of its times of decay in a step, the speed at the end was 0.0242 m/s, and the status ok: it is 0.0464 m/s.
TEST(FeedbackAudit, ASteepTableOverASpeedIsSeenWhereTheHalvesOfTheStepAgree) {
  for (const char* const dt : {"20 ms", "10 ms", "5 ms"}) {
    const AnalysedRun run(brake(dt));
    const hil::Verdict verdict = run.judge("v");
    EXPECT_THAT(verdict.unresolved, testing::HasSubstr("feedback")) << dt;
    EXPECT_NE(run.judge("x").unresolved, "") << dt;
    ASSERT_FALSE(verdict.is_resolved());
    const double enough = find_step(verdict.unresolved);
    EXPECT_LT(enough, 1e-3);
    EXPECT_GT(enough, 1e-4);
  }
  const AnalysedRun fine(brake("0.5 ms"));
  EXPECT_EQ(fine.judge("v").unresolved, "");
  EXPECT_NEAR(fine.judge("v").value, find_speed(0.1), 1e-6);
}

// Whatever the step: what is resolved is as near as it says.
TEST(FeedbackAudit, SpeedsUnderASteepTableAreWithinTheirUncertaintyOrUnresolved) {
  int resolved = 0;
  for (const double parts : {8, 10, 16, 20, 25, 32, 40, 50, 64, 80, 100, 125, 160, 200, 400}) {
    const AnalysedRun run(brake(std::to_string(1e5 / parts) + " us"));
    const hil::Verdict verdict = run.judge("v");
    if (!verdict.is_resolved()) continue;
    ++resolved;
    EXPECT_LE(std::abs(verdict.value - find_speed(0.1)), verdict.uncertainty + 1e-3 * find_speed(0.1)) << parts;
  }
  EXPECT_GE(resolved, 4);
}

// Neither a force that only time changes, nor one over a speed that another body has, is a feedback.
TEST(FeedbackAudit, ForcesThatDoNotDependOnTheMotionThatTheyCauseAreNone) {
  const AnalysedRun run(R"(unlatch: 1
name: driven
step: {dt: 10 ms, until: 1 s}
bodies:
  a: {mass: 1, inertia: [1, 1, 1]}
  b: {mass: 1, inertia: [1, 1, 1], position: [0, 5, 0], velocity: [1, 0, 0]}
quantities: {pace: {velocity: {body: b, component: x}}}
elements:
  swing: {type: force, body: b, frame: world, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 50 N, frequency: 12 rad/s}]}}
  follow: {type: force, body: a, frame: world, direction: [1, 0, 0], profile: {expression: "400 N*s/m * pace - 400 N"}}
requirements:
  - {id: a, velocity: {body: a, along: [1, 0, 0]}, at_most: 9 km/s}
  - {id: b, velocity: {body: b, along: [1, 0, 0]}, at_most: 9 km/s}
)");
  EXPECT_EQ(run.judge("a").unresolved, "");
  EXPECT_EQ(run.judge("b").unresolved, "");
  for (int body = 0; body < 2; ++body) EXPECT_EQ(run.analysis.accuracy().get_steps().get_feedback(body), 0);
}

// An explicit spring of 40 rad/s: h times that is 2. Its force was given to a third of what it is off by.
TEST(FeedbackAudit, TheErrorOfWhatIsUnresolvedIsNotKnown) {
  const std::string start = "unlatch: 1\nname: spring\nstep: {dt: ", end = R"(, until: 1 s}
bodies: {b: {mass: 1, inertia: [1, 1, 1], position: [0.1, 0, 0]}}
elements: {s: {type: spring, between: [ground, b], stiffness: 1600, free_length: 0}}
requirements: [{id: x, position: {body: b, along: [1, 0, 0]}, take: final, range: [-9, 9]}]
)";
  const hil::Verdict coarse = AnalysedRun(start + "50 ms" + end).judge("x");
  EXPECT_FALSE(coarse.is_resolved());
  EXPECT_FALSE(coarse.is_error_known());
  const hil::Verdict fine = AnalysedRun(start + "1 ms" + end).judge("x");
  EXPECT_TRUE(fine.is_resolved()) << fine.unresolved;
  EXPECT_TRUE(fine.is_error_known());
}

// Braked at 80/s, 0.8 of it in a step, it is at 10 mm after ln(5)/80 s.
TEST(FeedbackAudit, TheTimeOfAThresholdHasTheErrorOfWhatCrossesIt) {
  const auto run = [](const std::string& dt) {
    return AnalysedRun("unlatch: 1\nname: threshold\nstep: {dt: " + dt + R"(, until: 0.1}
bodies: {b: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}}
quantities: {x: {position: {body: b, component: x}}, v: {velocity: {body: b, component: x}}}
elements: {f: {type: force, body: b, frame: world, direction: [1, 0, 0], profile: {expression: "-80 N*s/m * v"}}}
events: [{name: far, when: {quantity: x, above: 10 mm}}]
requirements: [{id: t, time: {event: far}, at_most: 1 s}]
)");
  };
  const double exact = std::log(5.0) / 80;
  const AnalysedRun coarse = run("10 ms"), fine = run("0.5 ms");
  const hil::Verdict verdict = coarse.judge("t");
  EXPECT_TRUE(verdict.is_resolved()) << verdict.unresolved;
  EXPECT_GT(std::abs(verdict.value - exact), 1e-5);
  EXPECT_LE(std::abs(verdict.value - exact), verdict.uncertainty);
  EXPECT_LT(verdict.uncertainty, 0.1 * exact);
  ASSERT_EQ(coarse.analysis.timeline.size(), 1U);
  EXPECT_EQ(coarse.analysis.calc_time_uncertainty(coarse.analysis.timeline[0]), verdict.uncertainty);
  EXPECT_EQ(fine.judge("t").uncertainty, 0);
  EXPECT_NEAR(fine.judge("t").value, exact, 1e-8);
}

}  // namespace
}  // namespace unlatch::test::feedback_audit_test
