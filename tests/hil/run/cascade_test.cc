// Requirements at an instant at which events follow from others, and on events that come again.
#include <cmath>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::cascade_test {
namespace {

// At 0.5 s `first` takes 3 m/s from a body of 1 m/s, whereupon `second` gives it 2.5 m/s.
const char* const kCascade = R"(unlatch: 1
name: cascade
step: {dt: 10 ms, until: 1 s}
bodies:
  body: {mass: 1 kg, inertia: [1, 1, 1], velocity: [1, 0, 0]}
events:
  - {name: second, when: {velocity: {body: body, component: x}, below: 0}, then: [{impulse: {body: body, frame: world, linear: [2.5, 0, 0]}}]}
  - {name: first, when: {time: 0.5 s}, then: [{impulse: {body: body, frame: world, linear: [-3, 0, 0]}}]}
  - {name: beside, when: {time: 0.5 s}}
quantities: {vx: {velocity: {body: body, component: x}}}
requirements:
)";

TEST(Cascade, ValueAtAnEventIsThatJustBeforeItsActionsThoughOthersActedBeforeAtItsInstant) {
  const AnalysedRun run(std::string(kCascade) +
                        "  - {id: first, quantity: vx, at: first, at_least: 0}\n"
                        "  - {id: second, quantity: vx, at: second, at_most: 0}\n"
                        "  - {id: velocity, velocity: {body: body, component: x}, at: second, at_most: 0}\n"
                        "  - {id: expression, expression: vx * 2, at: second, at_most: 0}\n");
  EXPECT_NEAR(run.judge("first").value, 1, 1e-12);
  for (const char* id : {"second", "velocity"}) {
    EXPECT_NEAR(run.judge(id).value, -2, 1e-12) << id;
    EXPECT_NEAR(run.judge(id).time, 0.5, 1e-12) << id;
    EXPECT_TRUE(run.judge(id).is_met()) << id;
  }
  EXPECT_NEAR(run.judge("expression").value, -4, 1e-12);
}

TEST(Cascade, IntervalBetweenTwoEventsOfOneInstantHasTheStateBetweenThem) {
  const AnalysedRun run(std::string(kCascade) +
                        "  - {id: between, quantity: vx, from: first, to: second, take: minimum, at_least: -1}\n"
                        "  - {id: last, quantity: vx, from: first, to: second, take: final, at_least: -1}\n"
                        "  - {id: to, quantity: vx, to: second, take: final, at_least: -1}\n"
                        "  - {id: reverse, quantity: vx, from: second, to: first, take: minimum, at_least: -1}\n"
                        "  - {id: once, quantity: vx, from: first, to: beside, take: minimum, at_least: -1}\n");
  for (const char* id : {"between", "last", "to"}) {
    EXPECT_TRUE(run.judge(id).evaluated) << id << ": " << run.judge(id).why;
    EXPECT_NEAR(run.judge(id).value, -2, 1e-12) << id;
    EXPECT_NEAR(run.judge(id).time, 0.5, 1e-12) << id;
    EXPECT_FALSE(run.judge(id).is_met()) << id;
  }
  EXPECT_FALSE(run.judge("reverse").evaluated);
  EXPECT_FALSE(run.judge("once").evaluated) << "they act at once, with no state between them";
}

TEST(Cascade, StatesBetweenItsEventsBelongToIntervalsThatGoOn) {
  const AnalysedRun run(std::string(kCascade) +
                        "  - {id: whole, quantity: vx, take: minimum, at_least: -1}\n"
                        "  - {id: expression, expression: abs(vx), take: maximum, at_most: 1.5 m/s}\n"
                        "  - {id: velocity, velocity: {body: body, component: x}, take: minimum, at_least: -1}\n"
                        "  - {id: from, quantity: vx, from: first, take: minimum, at_least: -1}\n"
                        "  - {id: behind, quantity: vx, from: second, take: minimum, at_least: -1}\n"
                        "  - {id: before, quantity: vx, to: first, take: minimum, at_least: -1}\n");
  for (const char* id : {"whole", "velocity", "from"}) EXPECT_NEAR(run.judge(id).value, -2, 1e-12) << id;
  EXPECT_NEAR(run.judge("expression").value, 2, 1e-12);
  EXPECT_NEAR(run.judge("behind").value, 0.5, 1e-12);
  EXPECT_NEAR(run.judge("before").value, 1, 1e-12);
}

TEST(Cascade, OrderOfEventsOfOneInstantIsThatInWhichTheyActed) {
  const AnalysedRun run(std::string(kCascade) +
                        "  - {id: right, order: [first, second], at_least: 0}\n"
                        "  - {id: wrong, order: [second, first], at_least: 0}\n"
                        "  - {id: roughly, order: [second, first], at_least: -1 ms}\n"
                        "  - {id: together, order: [first, beside, second], at_least: 0}\n"
                        "  - {id: time, time: {event: second, after: first}, at_most: 1 ms}\n");
  for (const char* id : {"right", "roughly", "together", "time"}) {
    EXPECT_EQ(run.judge(id).value, 0) << id;
    EXPECT_TRUE(run.judge(id).is_met()) << id;
  }
  EXPECT_FALSE(run.judge("wrong").is_met());
  EXPECT_EQ(run.judge("wrong").why, "event 'first' acted before 'second', both at 0.5 s");
}

// A weld bears half of a force of 10 N until `second` lets go of it, whereupon `loose` acts.
TEST(Cascade, ReactionAtAnEventThatFollowsFromTheReleaseOfItsJointIsZero) {
  const AnalysedRun run(R"(unlatch: 1
name: release
step: {dt: 10 ms, until: 0.1 s}
bodies:
  near: {mass: 1 kg, inertia: [1, 1, 1]}
  far: {mass: 1 kg, inertia: [1, 1, 1], position: [0, 3, 0]}
joints:
  weld: {between: [near, far], point: [0, 3, 0], modes: {hold: {kind: weld}, free: {kind: free}}, mode: hold}
elements:
  pull: {type: force, body: far, direction: [0, 1, 0], frame: world, profile: 10 N}
events:
  - {name: loose, when: {mode: {joint: weld, is: free}}}
  - {name: release, when: {time: 55 ms}, then: [{set_mode: {joint: weld, mode: free}}]}
quantities: {force: {reaction_force: weld}}
requirements:
  - {id: loose, quantity: force, at: loose, at_most: 1 N}
  - {id: reaction, reaction: {joint: weld, row: force}, at: loose, at_most: 1 N}
  - {id: release, quantity: force, at: release, at_most: 100 N}
)");
  EXPECT_EQ(run.judge("loose").value, 0);
  EXPECT_EQ(run.judge("reaction").value, 0);
  EXPECT_TRUE(run.judge("loose").is_met());
  EXPECT_NEAR(run.judge("release").value, 5, 1e-9);
}

// A ball falls 1 m from rest and keeps half of its speed at each touch of the floor.
const char* const kBounce = R"(unlatch: 1
name: bounce
step: {dt: 10 ms, until: 1 s}
gravity: {uniform: [0, 0, -10]}
bodies:
  ball: {mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [0, 0, 1.1], shape: [{sphere: {radius: 0.1}}]}
ground: {shape: [{name: floor, half_space: {normal: [0, 0, 1]}}]}
contacts: {floor: {between: [ground.floor, ball], rigid: true, restitution: 0.5}}
events:
  - {name: hit, when: {contact: floor}}
quantities:
  vz: {velocity: {body: ball, component: z}}
  closed: {contact: floor}
requirements:
)";

TEST(Cascade, TouchAndLiftOfARigidBounceAreThoseOfOneBlow) {
  const AnalysedRun run(std::string(kBounce) +
                        "  - {id: touch, quantity: vz, at: 'touch:floor', at_most: 0}\n"
                        "  - {id: hit, quantity: vz, at: hit, at_most: 0}\n"
                        "  - {id: lift, quantity: vz, at: 'lift:floor', at_least: 0}\n"
                        "  - {id: between, quantity: vz, from: 'touch:floor', to: 'lift:floor', range: [2, 2.5]}\n"
                        "  - {id: fall, quantity: vz, to: 'touch:floor', take: final, at_most: 0}\n"
                        "  - {id: order, order: ['touch:floor', 'lift:floor'], at_least: 0}\n"
                        "  - {id: time, time: {event: 'lift:floor', after: 'touch:floor'}, at_most: 1 ms}\n");
  const double speed = std::sqrt(20.0), time = std::sqrt(0.2);
  for (const char* id : {"touch", "hit", "fall"}) EXPECT_NEAR(run.judge(id).value, -speed, 1e-6) << id;
  EXPECT_NEAR(run.judge("lift").value, 0.5 * speed, 1e-6);
  EXPECT_TRUE(run.judge("between").evaluated) << run.judge("between").why;
  EXPECT_NEAR(run.judge("between").value, 0.5 * speed, 1e-6);
  EXPECT_NEAR(run.judge("between").time, time, 1e-8);
  EXPECT_TRUE(run.judge("between").is_met());
  EXPECT_TRUE(run.judge("order").is_met());
  EXPECT_EQ(run.judge("time").value, 0);
}

TEST(Cascade, ContactThatClosesForAnInstantIsClosed) {
  const AnalysedRun run(std::string(kBounce) +
                        "  - {id: never, quantity: closed, take: maximum, at_most: 0}\n"
                        "  - {id: expression, expression: closed, take: maximum, at_most: 0}\n"
                        "  - {id: flight, quantity: closed, to: 'touch:floor', take: maximum, at_most: 0}\n");
  for (const char* id : {"never", "expression"}) {
    EXPECT_EQ(run.judge(id).value, 1) << id;
    EXPECT_FALSE(run.judge(id).is_met()) << id;
  }
  EXPECT_TRUE(run.judge("flight").is_met());
}

TEST(Cascade, EventsBehindTheRoundsThatAreKeptHaveNoValue) {
  std::string text = R"(unlatch: 1
name: chain
step: {dt: 10 ms, until: 0.1 s}
bodies:
  body: {mass: 1 kg, inertia: [1, 1, 1], velocity: [1, 0, 0]}
signals: [s0)";
  constexpr int kEvents = 40;
  for (int i = 1; i <= kEvents; ++i) text += ", s" + std::to_string(i);
  text += "]\nevents:\n  - {name: e0, when: {time: 55 ms}, then: [{raise: s0}]}\n";
  for (int i = 1; i <= kEvents; ++i)
    text += "  - {name: e" + std::to_string(i) + ", when: {signal: s" + std::to_string(i - 1) + "}, then: [{raise: s" +
            std::to_string(i) + "}, {impulse: {body: body, frame: world, linear: [1, 0, 0]}}]}\n";
  text +=
      "requirements:\n"
      "  - {id: kept, velocity: {body: body, component: x}, at: e20, at_most: 100}\n"
      "  - {id: lost, velocity: {body: body, component: x}, at: e38, at_most: 100}\n"
      "  - {id: from, velocity: {body: body, component: x}, from: e38, at_most: 100}\n";
  const AnalysedRun run(text);
  EXPECT_NEAR(run.judge("kept").value, 20, 1e-9);
  EXPECT_FALSE(run.judge("lost").evaluated);
  EXPECT_NE(run.judge("lost").why.find("32 rounds"), std::string::npos) << run.judge("lost").why;
  EXPECT_FALSE(run.judge("from").is_met());
}

// `again` acts at 0.2, 0.6 and 0.9 s.
const char* const kAgain = R"(unlatch: 1
name: again
step: {dt: 10 ms, until: 1 s}
bodies:
  body: {mass: 1 kg, inertia: [1, 1, 1], velocity: [1, 0, 0]}
events:
  - name: again
    when: {any: [{all: [{time: 0.2 s}, {not: {time: 0.3 s}}]}, {all: [{time: 0.6 s}, {not: {time: 0.7 s}}]}, {time: 0.9 s}]}
    repeat: true
  - {name: middle, when: {time: 0.4 s}}
quantities: {x: {position: {body: body, component: x}}}
requirements:
)";

TEST(RepeatedEvents, TimeAfterAnotherIsThatOfTheFirstOccurrenceBehindIt) {
  const AnalysedRun run(std::string(kAgain) +
                        "  - {id: after, time: {event: again, after: middle}, at_most: 0.1 s}\n"
                        "  - {id: before, time: {event: middle, after: again}, at_most: 0.3 s}\n"
                        "  - {id: first, time: {event: again}, at_most: 0.3 s}\n"
                        "  - {id: interval, quantity: x, from: middle, to: again, take: maximum, at_most: 9}\n");
  EXPECT_NEAR(run.judge("after").value, 0.2, 1e-9);
  EXPECT_NEAR(run.judge("after").time, 0.6, 1e-9);
  EXPECT_FALSE(run.judge("after").is_met());
  EXPECT_NEAR(run.judge("before").value, 0.2, 1e-9);
  EXPECT_NEAR(run.judge("first").value, 0.2, 1e-9);
  EXPECT_NEAR(run.judge("interval").value, 0.6, 1e-9);
}

// A signal is raised at 0.1 s and, if `twice`, lowered and raised again within the delay of the event that waits for
// it.
std::string build_delayed(bool twice) {
  return std::string(R"(unlatch: 1
name: delayed
step: {dt: 10 ms, until: 1 s}
bodies:
  body: {mass: 1 kg, inertia: [1, 1, 1]}
signals: [go]
events:
  - {name: up, when: {time: 0.1 s}, then: [{raise: go}]}
  - {name: down, when: {time: 0.15 s}, then: [{raise: {signal: go, to: 0}}]}
  - {name: again, when: {time: )") +
         (twice ? "0.25" : "0.5") + R"( s}, then: [{raise: go}]}
  - {name: push, when: {signal: go}, delay: 0.3 s, repeat: true, then: [{impulse: {body: body, frame: world, linear: [1, 0, 0]}}]}
requirements:
  - {id: speed, velocity: {body: body, component: x}, take: final, at_most: 9}
)";
}

TEST(RepeatedEvents, ConditionThatComesAgainDuringADelayIsReported) {
  const auto list = [](const AnalysedRun& run) {
    std::vector<std::string> texts;
    for (const hil::RunNotice& notice : run.analysis.accuracy().get())
      if (notice.name == "delay" && notice.subject == "push") texts.push_back(notice.text);
    return texts;
  };
  const AnalysedRun once(build_delayed(true)), both(build_delayed(false));
  ASSERT_EQ(list(once).size(), 1u);
  EXPECT_NE(list(once)[0].find("again at 0.25 s, while its delay of 0.3 s ran"), std::string::npos) << list(once)[0];
  EXPECT_NEAR(once.judge("speed").value, 1, 1e-12);
  EXPECT_TRUE(once.judge("speed").is_met());
  EXPECT_TRUE(list(both).empty());
  EXPECT_NEAR(both.judge("speed").value, 2, 1e-12);
}

TEST(Blows, RequirementsOnWhateverReadsAForceOfTheBlowSayThatItsImpulseIsNotInIt) {
  const AnalysedRun run(R"(unlatch: 1
name: blow
step: {dt: 10 ms, until: 1 s}
gravity: {uniform: [0, 0, -10]}
bodies:
  ball: {mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [0, 0, 1.1], shape: [{sphere: {radius: 0.1}}]}
  load: {mass: 3 kg, inertia: [0.01, 0.01, 0.01], position: [0, 0, 1.5]}
ground: {shape: [{name: floor, half_space: {normal: [0, 0, 1]}}]}
joints: {weld: {between: [ball, load], point: [0, 0, 0.2], follower_point: [0, 0, -0.2], modes: {hold: {kind: weld}}}}
contacts: {floor: {between: [ground.floor, ball], rigid: true, restitution: 0.5}}
quantities: {force: {reaction_force: weld}, vz: {velocity: {body: ball, component: z}}}
requirements:
  - {id: reaction, quantity: force, at_most: 100}
  - {id: expression, expression: force * 2, at_most: 100 N}
  - {id: floor, contact_force: floor, at_most: 100}
  - {id: contact, contact: {name: floor, value: force}, at_most: 100}
  - {id: ratio, expression: 2 * force / (1 N) + vz / (1 m/s), at_most: 100}
  - {id: fall, expression: force * 2, to: 'touch:floor', at_most: 100 N}
  - {id: speed, expression: vz * 2, at_most: 100 m/s}
)");
  for (const char* id : {"reaction", "expression", "floor", "contact", "ratio"})
    EXPECT_NEAR(run.judge(id).blow, std::sqrt(0.2), 1e-8) << id;
  for (const char* id : {"fall", "speed"}) EXPECT_FALSE(run.judge(id).leaves_out_blow()) << id;
}

TEST(Distances, LimitThatIsMissedByRoundingIsMet) {
  const AnalysedRun run(std::string(kBounce) +
                        "  - {id: clearance, clearance: [ground, ball], at_least: 0}\n"
                        "  - {id: quantity, quantity: {clearance: {between: [ground.floor, ball]}}, at_least: 0}\n"
                        "  - {id: missed, clearance: [ground, ball], at_least: 2e-8}\n");
  EXPECT_NE(run.judge("clearance").value, 0) << "it is missed by rounding";
  for (const char* id : {"clearance", "quantity"}) {
    EXPECT_NEAR(run.judge(id).value, 0, 1e-8) << id;
    EXPECT_TRUE(run.judge(id).is_met()) << id;
    EXPECT_GE(run.judge(id).margin, 0) << id;
  }
  EXPECT_FALSE(run.judge("missed").is_met());
}

// A value is off by what it says, and by what it need not say, at most.
void expect_honest(const AnalysedRun& run, const std::string& id, double exact) {
  const hil::Verdict verdict = run.judge(id);
  EXPECT_LE(std::abs(verdict.value - exact), verdict.uncertainty + hil::Verdict::kExact * std::abs(exact))
      << id << ": " << verdict.value << " ± " << verdict.uncertainty;
}

// A ball flies at 3 m/s from one wall to another, 1.6 m apart: it is farthest from both, 0.7 m, in the middle.
TEST(Extremes, DistanceToTheNearerOfTwoShapesHasItsCornerInExpressions) {
  for (const double start : {-1.0, -1.005, -1.01, -1.013, -1.02}) {
    const AnalysedRun run(R"(unlatch: 1
name: corner
step: {dt: 10 ms, until: 0.4 s}
bodies:
  ball: {mass: 1 kg, inertia: [1, 1, 1], position: [)" +
                          std::to_string(start) + R"(, 0.2, 0.3], velocity: [3, 0, 0], shape: [{sphere: {radius: 0.1}}]}
  walls: {mass: 1 kg, inertia: [1, 1, 1], shape: [{name: left, box: {centre: [-2.2, 0, 0], size: [1.8, 4, 4]}}, {name: right, box: {centre: [2.2, 0, 0], size: [3.8, 4, 4]}}]}
quantities: {distance: {clearance: {between: [ball, walls]}}}
requirements:
  - {id: clearance, clearance: [ball, walls], take: maximum, at_most: 0.695 m}
  - {id: quantity, quantity: distance, take: maximum, at_most: 0.695 m}
  - {id: expression, expression: distance * 1, take: maximum, at_most: 0.695 m}
  - {id: negative, expression: -distance, take: minimum, at_least: -0.695 m}
)");
    EXPECT_NEAR(run.judge("clearance").value, 0.7, 1e-9);
    for (const char* id : {"quantity", "expression"}) expect_honest(run, id, 0.7);
    expect_honest(run, "negative", -0.7);
    for (const char* id : {"clearance", "quantity", "expression", "negative"})
      EXPECT_FALSE(run.judge(id).is_met()) << id << " from " << start;
  }
}

// The end of a cord passes its drum along a tangent's neighbour: it is then farther off the tangent than at any knot.
TEST(Extremes, WindingOfACordThatPassesItsDrumIsKnownInExpressionsAsItIsAlone) {
  const AnalysedRun run(R"(unlatch: 1
name: wound
step: {dt: 10 ms, until: 0.3 s}
bodies:
  end: {mass: 1 kg, inertia: [1, 1, 1], position: [0.5, 1.06, 0], velocity: [0, -10, 0]}
elements:
  cord: {type: cord, between: [ground, end], wraps: {axis: [0, 0, 1], radius: 0.3, wound: 0.05}, length: 5, stiffness: 1 N/m}
quantities: {wound: {wound: cord}}
requirements:
  - {id: quantity, quantity: wound, take: minimum, at_least: -0.9}
  - {id: expression, expression: wound, take: minimum, at_least: -0.9}
)");
  const double exact = -0.947224;
  for (const char* id : {"quantity", "expression"}) {
    expect_honest(run, id, exact);
    EXPECT_FALSE(run.judge(id).is_met()) << id;
  }
}

}  // namespace
}  // namespace unlatch::test::cascade_test
