// The audit of the step: runs whose step is too long, against the same runs with one that is not, and smooth systems of
// all kinds that no audit may doubt.
#include "hil/run/audit/step_audit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <set>
#include <string>

#include "hil/study/evaluation/evaluation.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::step_audit_test {
namespace {

std::set<std::string> list_steps(const AnalysedRun& run) {
  std::set<std::string> subjects;
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == "step" && notice.unresolved) subjects.insert(notice.subject);
  return subjects;
}

// A ball of 1 kg under a law, and another body that is a thousand times as fast and heavy.
std::string push_beside(const std::string& law, const std::string& dt) {
  return "unlatch: 1\nname: beside\nstep: {dt: " + dt + R"(, until: 1}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}
  fast: {mass: 1000, inertia: [1, 1, 1], position: [0, 50, 0], velocity: [0, 1000, 0]}
quantities: {place: {position: {body: ball, component: x}}, pace: {velocity: {body: ball, component: x}}}
elements: {push: {type: force, body: ball, frame: world, direction: [1, 0, 0], profile: {expression: ")" +
         law + R"("}}}
requirements:
  - {id: slow, velocity: {body: ball, along: [1, 0, 0]}, at_most: 1 km/s}
  - {id: far, position: {body: fast, along: [0, 1, 0]}, take: final, at_least: 1 m}
)";
}

// h·ω = 2, 1.2 and 0.7 of 100 steps, hτ = 2.5 of a drag, a bump that is a tenth of the step.
TEST(StepAudit, ALawThatTheStepDoesNotResolveIsSeenBesideAFastBody) {
  for (const char* const law : {"-4e4 N/m * place", "-1.44e4 N/m * place", "-4.9e3 N/m * place", "-250 N*s/m * pace",
                                "100 N * exp(-((time - 0.505 s) / (1 ms))^2)"}) {
    const AnalysedRun run(push_beside(law, "10 ms"));
    EXPECT_THAT(list_steps(run), testing::ElementsAre("ball")) << law;
    EXPECT_NE(run.judge("slow").unresolved, "") << law;
    EXPECT_EQ(run.judge("far").unresolved, "") << law;
    EXPECT_THAT(list_steps(AnalysedRun(push_beside(law, "0.2 ms"))), testing::IsEmpty()) << law;
  }
}

// h·ω = 0.555 of 100 steps: the place at the end is 46.9 mm, and cos(ω t) 0.1 m = 51.2 mm. Results that are farther
// from their limits than that stand.
TEST(StepAudit, AMarginThatIsLessThanTheErrorOfTheStepsDecidesNothing) {
  const auto judge = [](const std::string& dt, const std::string& limit) {
    return AnalysedRun("unlatch: 1\nname: swing\nstep: {dt: " + dt + R"(, until: 1 s}
bodies: {ball: {mass: 1, inertia: [1, 1, 1], position: [0.1, 0, 0]}}
quantities: {place: {position: {body: ball, component: x}}}
elements: {spring: {type: force, body: ball, direction: [1, 0, 0], profile: {expression: "-3082 N/m * place"}}}
requirements:
  - {id: near, quantity: place, take: final, at_most: )" +
                       limit + "}\n")
        .judge("near");
  };
  const hil::Verdict wrong = judge("10 ms", "50 mm");
  EXPECT_NE(wrong.unresolved.find("may be more than the margin"), std::string::npos) << wrong.value;
  EXPECT_TRUE(judge("10 ms", "100 mm").is_met());
  const hil::Verdict right = judge("1 ms", "50 mm");
  EXPECT_TRUE(right.is_resolved()) << right.unresolved;
  EXPECT_FALSE(right.is_met());
  EXPECT_NEAR(right.value, 0.1 * std::cos(std::sqrt(3082.0)), 1e-6);
}

TEST(StepAudit, LawsThatJumpAreResolved) {
  for (const char* const law :
       {"if_less(time, 0.5 s, 0 N, if_less(time, 0.5001 s, 100 N, 0 N))", "if_less(time, 0.5 s, 0 N, 10 N)",
        "if_less(time, 0.5037 s, 0 N, 10 N)", "if_less(time, 0.5 s, 0 N, if_less(time, 0.506 s, 100 N, 0 N))",
        "if_less(abs(time - 0.505 s), 2 ms, 100 N, 0 N)", "1e8 * time^5 * 1 N/s^5"})
    for (const char* const dt : {"10 ms", "1 ms"})
      EXPECT_THAT(list_steps(AnalysedRun(push_beside(law, dt))), testing::IsEmpty()) << law << " at " << dt;
}

// A body on a spring of 1e6 N/m, hω = 10 at 10 ms. A force that jumps to 10 kN deflects it by 10 mm, and in truth by up
// to 20 mm; one that grows slowly deflects it rightly, but its velocity is 4.5 times the true one.
std::string push_spring(const std::string& force, const std::string& dt) {
  return "unlatch: 1\nname: spring\nstep: {dt: " + dt + R"(, until: 1}
bodies: {ball: {mass: 1, inertia: [1, 1, 1]}}
joints: {rail: {between: [ground, ball], modes: {slides: {kind: prismatic, axis: x}}}}
elements:
  spring: {type: joint_spring, joint: rail, axis: x, stiffness: 1e6}
  push: {type: force, body: ball, frame: world, direction: [1, 0, 0], profile: {expression: ")" +
         force + R"("}}
requirements: [{id: deflection, displacement: {joint: rail, axis: x}, at_most: 1 m}]
)";
}

TEST(StepAudit, AnImplicitSpringWhosePeriodTheStepDoesNotResolveIsUnresolved) {
  for (const char* const force :
       {"if_less(time, 0.5037 s, 0 N, 10000 N)", "10000 N * time^2 * (3 - 2 * time / (1 s)) / (1 s^2)"}) {
    const AnalysedRun run(push_spring(force, "10 ms"));
    EXPECT_THAT(list_steps(run), testing::ElementsAre("ball")) << force;
    EXPECT_NE(run.judge("deflection").unresolved, "") << force;
    EXPECT_THAT(list_steps(AnalysedRun(push_spring(force, "0.1 ms"))), testing::IsEmpty()) << force;
  }
}

// Bodies on springs, dampers and laws of place, pace and time, spinning, falling and joined: all well resolved.
std::string build_smooth(unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const auto text = [](double value) { return std::to_string(value); };
  const auto vector = [&](double size) {
    return "[" + text(draw(-size, size)) + ", " + text(draw(-size, size)) + ", " + text(draw(-size, size)) + "]";
  };
  const int count = 1 + static_cast<int>(seed % 4);
  std::string bodies, elements, quantities, joints;
  for (int i = 0; i < count; ++i) {
    const bool held = count > 2 && i < 2;  // by a ball joint between the first two
    const std::string name = "b" + std::to_string(i);
    bodies += "  " + name + ": {mass: " + text(draw(0.5, 50)) + ", inertia: [1, " + text(draw(1, 1.5)) + ", " +
              text(draw(1, 1.8)) + "], position: [" + text(2.0 * i) + ", 0, " + text(held ? 0 : draw(-0.3, 0.3)) +
              "], velocity: " + vector(held ? 0 : draw(0, 10)) + ", rate: " + vector(held ? 0 : draw(0, 15)) + "}\n";
    quantities += "  x" + name + ": {position: {body: " + name + ", component: z}}\n  v" + name +
                  ": {velocity: {body: " + name + ", component: y}}\n";
    elements += "  f" + name + ": {type: force, body: " + name + ", frame: world, point: " + vector(0.1) +
                ", direction: " + vector(1) + ", profile: {expression: \"" + text(draw(0, 20)) + " N * sin(" +
                text(draw(1, 40)) + " * time / (1 s)) - " + text(draw(0, 5)) + " N/m * x" + name + " - " +
                text(draw(0, 5)) + " N*s/m * v" + name + "\"}}\n";
    if (i > 0)
      elements += "  s" + name + ": {type: spring, between: [b" + std::to_string(i - 1) + ", " + name +
                  "], stiffness: " + text(draw(0, 200)) + ", damping: " + text(draw(0, 3)) +
                  ", free_length: " + text(draw(0.5, 2)) + "}\n";
  }
  if (count > 2)
    joints =
        "joints: {j: {between: [b0, b1], point: [1, 0, 0], follower_point: [-1, 0, 0], modes: {held: {kind: ball}}}}\n";
  return "unlatch: 1\nname: smooth\nstep: {dt: 2 ms, until: 2}\ngravity: {uniform: [0, 0, -9.81]}\nbodies:\n" + bodies +
         "quantities:\n" + quantities + "elements:\n" + elements + joints;
}

TEST(StepAudit, SixtySmoothSystemsAreResolved) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const AnalysedRun run(build_smooth(seed));
    EXPECT_THAT(list_steps(run), testing::IsEmpty()) << "seed " << seed << "\n" << build_smooth(seed);
    const hil::StepError worst = run.analysis.accuracy().get_steps().find_worst();
    EXPECT_LT(worst.error, 0.02 * worst.change) << "seed " << seed;
  }
}

// Ticks with releases, impulses, latches and touches within them.
TEST(StepAudit, EventsWithinStepsAreNoErrors) {
  const AnalysedRun run(R"(unlatch: 1
name: events
step: {dt: 5 ms, until: 1}
bodies:
  a: {mass: 2, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 2, inertia: [1, 1, 1], position: [1, 0, 0], shape: [{sphere: {radius: 0.1}}]}
joints:
  hold: {between: [a, b], follower_point: [-1, 0, 0], modes: {held: {kind: weld}, free: {kind: free}}, mode: held}
elements:
  s: {type: spring, between: [a, b], stiffness: 400, damping: 1, free_length: 2, push_only: true}
  t: {type: thrust, body: b, point: [0, 0.2, 0], direction: [-1, 0, 0], profile: 40}
events:
  - {name: release, when: {time: 0.1234}, then: [{set_mode: {joint: hold, mode: free}}]}
  - {name: latch, when: {time: 0.4321}, then: [{set_mode: {joint: hold, mode: held}}]}
  - {name: again, when: {time: 0.6111}, then: [{set_mode: {joint: hold, mode: free}}]}
)");
  EXPECT_THAT(list_steps(run), testing::IsEmpty());
}

TEST(StepAudit, ItObservesAloneAndItsCostIsBounded) {
  for (const unsigned seed : {3U, 4U}) {
    AnalysedRun audited(build_smooth(seed));
    const auto simulation = hil::build_simulation(audited.scenario);
    while (simulation->get_tick() < audited.simulation->get_tick())
      ASSERT_EQ(simulation->step().status, StepStatus::kOk);
    EXPECT_EQ(audited.simulation->calc_hash(), simulation->calc_hash());
    const hil::StepAudit& steps = audited.analysis.accuracy().get_steps();
    EXPECT_EQ(steps.get_ticks(), 1000);
    EXPECT_GE(steps.get_compared(), 1000 / 128);
    EXPECT_LE(steps.get_compared(), 1000 / 128 + 1 + 12 + 1000 / 256);
  }
}

// A rate that is constant but for the rounding and the truncation of its steps has not changed by these.
TEST(StepAudit, ASteadyRateIsResolved) {
  const AnalysedRun run(R"(unlatch: 1
name: arm
step: {dt: 1 ms, until: 2}
bodies: {arm: {mass: 1, inertia: [0.1, 0.2, 0.2], position: [1, 0, 0], velocity: [0, 70, 0], rate: [0, 0, 70]}}
joints: {hinge: {between: [ground, arm], follower_point: [-1, 0, 0], modes: {turns: {kind: revolute, axis: z}}}}
)");
  EXPECT_THAT(list_steps(run), testing::IsEmpty());
}

// A sample of a campaign or a search has the audit of a run.
TEST(StepAudit, ASampleIsJudgedAsTheRunOfItsScenario) {
  for (const char* const law : {"-4e4 N/m * place", "-4 N/m * place"}) {
    const std::string text = push_beside(law, "10 ms");
    const hil::ScenarioTree tree = hil::ScenarioTree(hil::ScenarioSources(text, ""), "s.yaml");
    const hil::SampleResult sample = hil::SampleEvaluator(tree).evaluate({});
    const AnalysedRun run(text);
    EXPECT_EQ(sample.status == hil::SampleStatus::kUnresolved, !list_steps(run).empty()) << law;
    EXPECT_EQ(sample.message, run.analysis.accuracy().describe_unresolved());
  }
}

}  // namespace
}  // namespace unlatch::test::step_audit_test
