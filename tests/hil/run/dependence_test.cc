// What depends on a body that the step does not resolve: bodies that were linked to it from the time of the error on,
// whatever links there are at the end.
#include <gmock/gmock.h>

#include <string>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::dependence_test {
namespace {

// A ball under a law that 10 ms do not resolve, from `from` on, and riders on rails along its motion, which feel none
// of it.
std::string build_riders(const std::string& from, const std::string& riders, const std::string& rest) {
  return R"(unlatch: 1
name: riders
step: {dt: 10 ms, until: 1}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}
  a: {mass: 100, inertia: [1, 1, 1], velocity: [1, 0, 0]}
  b: {mass: 100, inertia: [1, 1, 1], velocity: [1, 0, 0]}
  c: {mass: 100, inertia: [1, 1, 1], velocity: [1, 0, 0]}
quantities: {place: {position: {body: ball, component: x}}}
elements: {push: {type: force, body: ball, frame: world, direction: [1, 0, 0], profile: {expression: "if_less(time, )" +
         from + R"--(, 0 N, -4e4 N/m * place)"}}}
joints:
)--" + riders +
         "events:\n" + rest +
         R"(requirements:
  - {id: ball, velocity: {body: ball}, take: final, at_most: 1 km/s}
  - {id: a, velocity: {body: a}, take: final, at_most: 1 km/s}
  - {id: b, velocity: {body: b}, take: final, at_most: 1 km/s}
  - {id: c, velocity: {body: c}, take: final, at_most: 1 km/s}
)";
}

std::string join(const std::string& name, const std::string& base, const std::string& follower, bool held) {
  return "  " + name + ": {between: [" + base + ", " + follower +
         "], modes: {slides: {kind: prismatic, axis: x}, free: {kind: free}}, mode: " + (held ? "slides" : "free") +
         "}\n";
}

std::string set(const std::string& joint, const std::string& mode, const std::string& time) {
  return "  - {name: " + mode + ", subject: " + joint + ", when: {time: " + time +
         "}, then: [{set_mode: {joint: " + joint + ", mode: " + mode + "}}]}\n";
}

bool is_resolved(const AnalysedRun& run, const std::string& id) { return run.judge(id).unresolved.empty(); }

TEST(Dependence, ABodyThatLeftAfterTheErrorDependsOnIt) {
  const std::string joints = join("early", "ball", "a", true) + join("late", "ball", "b", true);
  const AnalysedRun run(build_riders("0.3 s", joints, set("early", "free", "0.1 s") + set("late", "free", "0.8 s")));
  EXPECT_FALSE(is_resolved(run, "ball"));
  EXPECT_TRUE(is_resolved(run, "a"));
  EXPECT_FALSE(is_resolved(run, "b"));
  EXPECT_TRUE(is_resolved(run, "c"));
}

TEST(Dependence, ABodyThatIsJoinedLaterDependsOnTheErrorAndOneThatLeftBeforeDoesNot) {
  const std::string joints =
      join("first", "ball", "a", true) + join("before", "a", "c", true) + join("then", "a", "b", false);
  // The error is there from 0.3 s on, and c leaves a before.
  const AnalysedRun run(
      build_riders("0.3 s", joints,
                   set("before", "free", "0.2 s") + set("first", "free", "0.6 s") + set("then", "slides", "0.8 s")));
  EXPECT_FALSE(is_resolved(run, "a"));
  EXPECT_FALSE(is_resolved(run, "b"));
  EXPECT_TRUE(is_resolved(run, "c"));
}

TEST(Dependence, WhatAnEventActsOnDependsOnTheBodiesOfItsGuard) {
  const std::string joints = join("hold", "a", "b", true);
  const std::string event =
      "  - {name: go, when: {quantity: place, below: -0.1 mm}, then: [{set_mode: {joint: hold, mode: free}}]}\n";
  const AnalysedRun run(build_riders("0 s", joints, event));
  EXPECT_FALSE(is_resolved(run, "a"));
  EXPECT_FALSE(is_resolved(run, "b"));
  EXPECT_TRUE(is_resolved(run, "c"));
  // One that has acted before the error depends on none.
  const std::string early =
      "  - {name: go, when: {quantity: place, above: 0.1 m}, then: [{set_mode: {joint: hold, mode: free}}]}\n";
  const AnalysedRun resolved(build_riders("0.3 s", joints, early));
  EXPECT_FALSE(is_resolved(resolved, "ball"));
  EXPECT_TRUE(is_resolved(resolved, "b"));
}

// The ball swings under a law that 10 ms do not resolve until 0.2 s; then it is thrown so far that this is little.
TEST(Dependence, AValueOfAWhileThatWasNotResolvedDependsOnItAlthoughTheBodyMovesOn) {
  const AnalysedRun run(R"--(unlatch: 1
name: passed
step: {dt: 10 ms, until: 4}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}
quantities: {place: {position: {body: ball, component: x}}}
elements:
  push: {type: force, body: ball, frame: world, direction: [1, 0, 0],
         profile: {expression: "if_less(time, 0.2 s, -4e4 N/m * place, 1e5 N)"}}
events: [{name: thrown, when: {time: 0.2}}]
requirements:
  - {id: swing, velocity: {body: ball}, to: thrown, take: maximum, at_most: 1 km/s}
  - {id: last, velocity: {body: ball}, take: final, at_most: 1e6}
)--");
  EXPECT_FALSE(is_resolved(run, "swing"));
  EXPECT_TRUE(is_resolved(run, "last"));
  EXPECT_EQ(run.analysis.accuracy().describe_unresolved(), "");
}

// With the true motion of the ball it might have: a contact that stays open.
TEST(Dependence, WhatNeverEngagesLinksItsBodies) {
  const AnalysedRun run(R"--(unlatch: 1
name: open
step: {dt: 10 ms, until: 1}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0], shape: [{sphere: {radius: 0.1}}]}
  a: {mass: 100, inertia: [1, 1, 1], position: [9, 0, 0], shape: [{sphere: {radius: 0.1}}]}
  b: {mass: 100, inertia: [1, 1, 1], position: [0, 9, 0], shape: [{sphere: {radius: 0.1}}]}
quantities: {place: {position: {body: ball, component: x}}}
elements: {push: {type: force, body: ball, frame: world, direction: [1, 0, 0], profile: {expression: "-4e4 N/m * place"}}}
contacts: {pads: {between: [ball, a], stiffness: 1e5}}
requirements:
  - {id: a, velocity: {body: a}, take: final, at_most: 1 km/s}
  - {id: b, velocity: {body: b}, take: final, at_most: 1 km/s}
)--");
  EXPECT_FALSE(is_resolved(run, "a"));
  EXPECT_TRUE(is_resolved(run, "b"));
}

TEST(Dependence, WhatCommandsDriveDependsOnWhatSensorsMeasure) {
  const std::string text = R"(unlatch: 1
name: commanded
step: {dt: 10 ms, until: 1}
bodies:
  ball: {mass: 1, inertia: [1, 1, 1], velocity: [1, 0, 0]}
  a: {mass: 100, inertia: [1, 1, 1]}
  b: {mass: 100, inertia: [1, 1, 1]}
quantities: {place: {position: {body: ball, component: x}}}
channels: {thrust: {initial: 0, range: [0, 1], safe: 0}}
sensors: {gyro: {type: rate, body: ball}}
elements:
  push: {type: force, body: ball, frame: world, direction: [1, 0, 0], profile: {expression: "-4e4 N/m * place"}}
  jet: {type: force, body: a, frame: world, direction: [1, 0, 0], profile: 100 N, channel: thrust}
requirements:
  - {id: a, velocity: {body: a}, take: final, at_most: 1 km/s}
  - {id: b, velocity: {body: b}, take: final, at_most: 1 km/s}
)";
  for (const bool commanded : {false, true}) {
    const hil::Scenario scenario = hil::load_scenario_text(text, "run.yaml");
    const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
    hil::RunAnalysis analysis(scenario, *simulation);
    analysis.update(StepReport{});
    for (int tick = 0; tick < 100; ++tick) {
      if (commanded && tick == 50) {
        ASSERT_TRUE(simulation->set_channel(0, 0.5));
      }
      analysis.update(simulation->step());
    }
    const std::vector<hil::Verdict> verdicts = analysis.judge();
    EXPECT_EQ(verdicts[0].unresolved.empty(), !commanded);
    EXPECT_EQ(verdicts[1].unresolved, "");
  }
}

}  // namespace
}  // namespace unlatch::test::dependence_test
