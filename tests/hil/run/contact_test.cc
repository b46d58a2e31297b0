// Contacts of the language, and their results in a run, against closed forms.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "hil/run/analysis/accuracy.h"
#include "hil/run/findings/findings.h"
#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::contact_test {
namespace {

constexpr double kLocated = 1e-6;  // s, also for a peak: located inside the step
constexpr double kAudited = 1e-6;  // of an impact's energy loss: RK4 with eight sub-steps a millisecond

// A ball of 2 kg flies with 3 m/s at a wall of 10^9 kg: k = 2e5 N/m without damping is 316 rad/s, half a period 9.93
// ms.
std::string build_blow(const std::string& law, const std::string& rest = "", double gap = 0.3) {
  return R"(unlatch: 1
name: blow
step: {dt: 1 ms, until: 0.2, contact_substeps: 8}
bodies:
  wall: {mass: 1e9, inertia: [1e9, 1e9, 1e9], shape: [{name: face, box: {size: [2, 10, 10]}}]}
  ball: {mass: 2, inertia: [1, 1, 1], position: [)" +
         std::to_string(1.5 + gap) + R"(, 0, 0], velocity: [-3, 0, 0], shape: [{sphere: {radius: 0.5}}]}
contacts:
  blow: {between: [wall.face, ball], )" +
         law + "}\n" + rest;
}

std::optional<hil::RunNotice> find_notice(const AnalysedRun& run, const std::string& name) {
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == name) return notice;
  return std::nullopt;
}

TEST(Contacts, ABlowHasItsForceImpulseAndTimes) {
  const AnalysedRun run(
      build_blow("stiffness: 0.2 MN/m",
                 "requirements:\n"
                 "  - {id: force, contact: {name: blow}, at_most: 1 kN}\n"
                 "  - {id: depth, contact: {name: blow, value: depth}, at_most: 1 m}\n"
                 "  - {id: impulse, contact: {name: blow, value: impulse}, take: final, at_most: 20 N s}\n"
                 "  - {id: touch, time: {event: lift:blow, after: touch:blow}, at_most: 1 s}\n"));
  const double omega = std::sqrt(2e5 / 2), half = std::acos(-1.0) / omega;
  const std::vector<hil::ContactRecord> contacts = run.analysis.list_contacts();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(*contacts[0].touch, 0.1, 1e-9);
  EXPECT_NEAR(*contacts[0].lift, 0.1 + half, kLocated);
  EXPECT_NEAR(contacts[0].duration, half, kLocated);
  EXPECT_EQ(contacts[0].touches, 1);
  EXPECT_NEAR(contacts[0].peak_force, 3 * std::sqrt(2e5 * 2), 1e-3);
  EXPECT_NEAR(contacts[0].peak_time, 0.1 + half / 2, 1e-5);
  EXPECT_NEAR(contacts[0].depth, 3 / omega, 1e-7);
  EXPECT_NEAR(contacts[0].totals.impulse, 12, 1e-5);
  EXPECT_NEAR(contacts[0].totals.dissipated, 0, 1e-6);
  EXPECT_NEAR(run.judge("force").value, contacts[0].peak_force, 1e-9 * contacts[0].peak_force);
  EXPECT_NEAR(run.judge("force").time, contacts[0].peak_time, kLocated);
  EXPECT_NEAR(run.judge("depth").value, contacts[0].depth, 1e-9 * contacts[0].depth);
  EXPECT_FALSE(run.judge("force").is_met());
  EXPECT_NEAR(run.judge("impulse").value, 12, 1e-5);
  EXPECT_NEAR(run.judge("touch").value, half, kLocated);
  EXPECT_EQ(run.analysis.timeline.size(), 2u);
  EXPECT_FALSE(find_notice(run, "contact").has_value());
}

TEST(Contacts, EstimatedErrorsBoundTheTrueOnesOfABlow) {
  const auto list = [](const std::string& dt) {
    std::string text = build_blow("stiffness: 0.2 MN/m");
    text.replace(text.find("dt: 1 ms"), 8, "dt: " + dt);
    const AnalysedRun run(text);
    return hil::list_values(run.scenario, *run.simulation, run.analysis);
  };
  const std::vector<hil::NamedValue> full = list("2 ms"), half = list("1 ms"), quarter = list("0.5 ms");
  const AnalysedRun run(build_blow("stiffness: 0.2 MN/m"));
  const hil::AccuracyReport report = hil::compare_steps(run.scenario, *run.simulation, full, half, quarter);
  EXPECT_EQ(report.mismatch, "");
  const double omega = std::sqrt(2e5 / 2), swing = std::acos(-1.0) / omega;
  const std::map<std::string, double> truths{{"first touch of blow", 0.1},
                                             {"last lift of blow", 0.1 + swing},
                                             {"peak force of blow", 3 * std::sqrt(2e5 * 2)},
                                             {"greatest depth of blow", 3 / omega},
                                             {"impulse of blow", 12}};
  std::size_t found = 0;
  for (const hil::AccuracyEntry& entry : report.entries) {
    const auto truth = truths.find(entry.value.what);
    if (truth == truths.end()) continue;
    ++found;
    EXPECT_LT(std::abs(entry.value.value - truth->second), 3 * entry.error + 1e-10 * truth->second) << truth->first;
    EXPECT_LT(entry.error, 1e-3 * truth->second) << truth->first;
  }
  EXPECT_EQ(found, truths.size());
}

// A blow within one step and a half: its greatest force is between the knots, in the piece before the lift or after the
// touch.
TEST(Contacts, ARequirementOnAShortBlowHasTheValueOfTheTable) {
  for (const char* const law : {"stiffness: 2.5 MN/m", "stiffness: 2.5 MN/m, damping: 0.2", "hertz_stiffness: 60e6"}) {
    const AnalysedRun run(build_blow(law,
                                     "requirements:\n"
                                     "  - {id: force, contact: {name: blow}, at_most: 1 kN}\n"
                                     "  - {id: depth, contact: {name: blow, value: depth}, at_most: 1 m}\n"));
    const hil::ContactRecord blow = run.analysis.list_contacts().at(0);
    ASSERT_GT(blow.peak_force, 1e3);
    EXPECT_NEAR(run.judge("force").value, blow.peak_force, 1e-9 * blow.peak_force) << law;
    EXPECT_NEAR(run.judge("depth").value, blow.depth, 1e-9 * blow.depth) << law;
  }
}

// The second blow, which the thrust makes the greater one, comes after hundreds of ticks with nothing between the
// shapes.
TEST(Contacts, ARequirementHasTheGreatestForceOfTwoBlowsWithAFlightBetween) {
  std::string text = build_blow("stiffness: 0.2 MN/m",
                                "elements:\n"
                                "  push: {type: thrust, body: ball, point: [0, 0, 0], direction: [1, 0, 0], "
                                "profile: {constant: 5 N}}\n"
                                "requirements:\n"
                                "  - {id: force, contact: {name: blow}, at_most: 5 kN}\n"
                                "  - {id: depth, contact: {name: blow, value: depth}, at_most: 1 m}\n"
                                "  - {id: least, contact: {name: blow}, at_least: 1 N}\n"
                                "  - {id: end, contact: {name: blow}, take: final, at_most: 1 N}\n");
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  };
  replace("{name: face, box: {size: [2, 10, 10]}}",
          "{group: face, box: {size: [2, 10, 10]}}, {group: face, box: {centre: [4, 0, 0], size: [2, 10, 10]}}");
  replace("until: 0.2", "until: 0.6");
  const AnalysedRun run(text);
  const hil::ContactRecord contact = run.analysis.list_contacts().at(0);
  ASSERT_EQ(contact.touches, 2);
  // v² = v₀² + 2 a x with a = 2.5 m/s², over 0.3 m against it and 1 m along it; the way in the contact adds nothing.
  const double first = std::sqrt(9 - 2 * 2.5 * 0.3), second = std::sqrt(first * first + 2 * 2.5 * 1);
  constexpr double kThrust = 0.01;  // relative: the thrust goes on in the blow
  EXPECT_NEAR(contact.peak_force, second * std::sqrt(2e5 * 2), kThrust * contact.peak_force);
  EXPECT_NEAR(run.judge("force").value, contact.peak_force, 1e-9 * contact.peak_force);
  EXPECT_NEAR(run.judge("force").time, contact.peak_time, kLocated);
  EXPECT_NEAR(run.judge("depth").value, contact.depth, 1e-9 * contact.depth);
  EXPECT_EQ(run.judge("least").value, 0);
  EXPECT_EQ(run.judge("end").value, 0);
  EXPECT_NEAR(run.judge("end").time, 0.6, 1e-9);
}

TEST(Contacts, TheAuditExplainsTheEnergyThatABlowTakes) {
  const AnalysedRun run(build_blow("stiffness: 0.2 MN/m, restitution: {coefficient: 0.5, speed: 3 m/s}"));
  const hil::EnergyBalance& energy = run.analysis.accuracy().get_energy();
  EXPECT_NEAR(energy.contacts, -0.5 * 2 * 9 * 0.75, 1e-4);
  EXPECT_LT(std::abs(energy.unexplained), kAudited * 6.75);
}

TEST(Contacts, OneThatIsClosedAtTheStartIsReportedAndIsNoTouch) {
  const std::string text = build_blow("stiffness: 0.2 MN/m", "", -0.001);
  const AnalysedRun run(text);
  EXPECT_TRUE(run.analysis.list_contacts()[0].closed_at_start);
  EXPECT_FALSE(run.analysis.list_contacts()[0].touch.has_value());
  ASSERT_TRUE(find_notice(run, "contact").has_value());
  EXPECT_NE(find_notice(run, "contact")->text.find("closed at the start"), std::string::npos);
  const auto at_start = hil::build_simulation(run.scenario);
  bool found = false;
  for (const hil::Finding& finding : hil::list_findings(run.scenario, *at_start))
    found = found || (finding.name == "contact" && finding.where == "contact 'blow'");
  EXPECT_TRUE(found);
}

TEST(Contacts, AStepThatDoesNotResolveABlowIsReported) {
  const AnalysedRun run(build_blow("stiffness: 2000 MN/m"));  // √(k/m)·h = 3.95
  ASSERT_TRUE(find_notice(run, "contact").has_value());
  EXPECT_NE(find_notice(run, "contact")->text.find("sqrt(k/m)·h"), std::string::npos);
}

// Without a restitution nothing in the scenario names a speed: that of the bodies does, or 1 m/s.
TEST(Contacts, ABlowOfHertzThatTheStepDoesNotResolveIsForeseen) {
  const auto find = [](const std::string& text) -> std::string {
    const hil::Scenario scenario = hil::load_scenario_text(text, "s.yaml");
    for (const hil::Finding& finding : hil::list_findings(scenario, *hil::build_simulation(scenario)))
      if (finding.name == "contact") return finding.text;
    return "";
  };
  const std::string hard = build_blow("hertz_stiffness: 1e15, damping: 0.1");
  EXPECT_NE(find(hard).find("beyond what is stable"), std::string::npos) << find(hard);
  EXPECT_NE(find(hard).find("for a blow of 3 m/s"), std::string::npos) << find(hard);
  std::string at_rest = hard;
  at_rest.replace(at_rest.find("velocity: [-3, 0, 0]"), 20, "velocity: [0, 0, 0]");
  EXPECT_NE(find(at_rest).find("for a blow of 1 m/s"), std::string::npos) << find(at_rest);
  EXPECT_EQ(find(build_blow("hertz_stiffness: 1e6, damping: 0.1")), "");
}

// Each of them was taken in silence before.
TEST(Contacts, WhatCannotBeMeantIsRefused) {
  const auto list_errors = [](const std::string& text) -> std::string {
    try {
      hil::load_scenario_text(text, "s.yaml");
      return "";
    } catch (const hil::ScenarioError& error) {
      return error.what();
    }
  };
  const auto expect = [&](const std::string& text, const std::string& says) {
    EXPECT_NE(list_errors(text).find(says), std::string::npos) << list_errors(text);
  };
  const std::string second = "  more: {between: [ball, wall], stiffness: 1 kN/m}\n";
  expect(build_blow("stiffness: 1 MN/m", second),
         "s.yaml:9:19: contact 'blow' acts between ball.shape[0] and wall.face too");
  EXPECT_EQ(list_errors(build_blow("stiffness: 1 MN/m, enabled: false", second)), "") << "one may follow the other";
  expect(build_blow("stiffness: 1 MN/m, damping: 0, restitution: {coefficient: 0.5, speed: 1}"),
         "s.yaml:8:66: a contact with a damping and a restitution");
  std::string lines = build_blow("stiffness: 1 MN/m");
  for (const char* const shape : {"box: {size: [2, 10, 10]}", "sphere: {radius: 0.5}"})
    lines.replace(lines.find(shape), std::string(shape).size(), "capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 0}");
  expect(lines, "s.yaml:8:19: two lines: capsules of the radius 0 never overlap");

  const auto build_pair = [](const std::string& rest) {
    return "unlatch: 1\nname: pair\nstep: {dt: 1 ms, until: 1}\nbodies:\n  a: {mass: 1, inertia: [1, 1, 1]}\n"
           "  b: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}\n" +
           rest;
  };
  const auto part = [&](const std::string& parts, const std::string& more = "") {
    return build_pair(
        "joints: {j: {between: [a, b], point: [2, 0, 0], modes: {held: {kind: weld}, free: {kind: free}}, "
        "mode: held, parts: " +
        parts + "}}\n" + more);
  };
  expect(part("{mode: free, force: -10}"), "it would part without any load");
  expect(part("{mode: free, moment: 0}"), "it would part without any load");
  expect(part("{mode: held, force: 10}"), "joint 'j' parts into the mode in which it already is");
  EXPECT_EQ(list_errors(part("{mode: held, force: 10}",
                             "events: [{name: go, when: {time: 0.1}, then: [{set_mode: "
                             "{joint: j, mode: free}}]}]\n")),
            "")
      << "it has left it before";
  expect(build_pair("elements: {c: {type: cord, between: [a, b], stiffness: 1000, parts_at: -3}}\n"),
         "s.yaml:7:72: it would part without any load");
  expect(build_pair("events: [{name: bang, when: {time: 0.01}, then: [{impulse: {body: b}}]}]\n"),
         "an impulse without a size");
  const auto stop = [&](const std::string& kind, const std::string& stiffness) {
    return build_pair("joints: {j: {between: [a, b], point: [2, 0, 0], modes: {only: {kind: " + kind +
                      "}}}}\nstops: {f: {joint: j, axis: x, at_most: 0.1, stiffness: " + stiffness + "}}\n");
  };
  EXPECT_EQ(list_errors(stop("free", "10")), "");
  expect(stop("weld", "10"), "every mode of joint 'j' holds x: it never moves there");
  expect(stop("free", "0"), "its stiffness is 0, so that it stops nothing");
}

TEST(Contacts, EventsWaitForContactsAndClearances) {
  const AnalysedRun run(
      build_blow("stiffness: 0.2 MN/m",
                 "events:\n"
                 "  - {name: near, when: {clearance: {between: [wall, ball]}, below: 15 cm}}\n"
                 "  - {name: hit, when: {contact: blow}, then: [{switch: {element: blow, to: false}}]}\n"));
  ASSERT_GE(run.analysis.timeline.size(), 3u);
  EXPECT_EQ(run.analysis.timeline[0].name, "near");
  EXPECT_NEAR(run.analysis.timeline[0].time, 0.05, 1e-9);
  EXPECT_EQ(run.analysis.timeline[1].name, "hit");
  EXPECT_NEAR(run.simulation->state().bodies[1].v.x, -3, 1e-9) << "switched off at once, it pushes no more";
}

TEST(Contacts, ActionsReachTheirElementsBesideContacts) {
  const hil::Scenario scenario = hil::load_scenario_text(
      build_blow("stiffness: 0.2 MN/m",
                 "elements:\n"
                 "  push: {type: pusher, between: [wall, ball], point: [1, 1, 0], follower_point: [0, 1, 0], stroke: "
                 "0.1, preload: 1, stiffness: 10}\n"
                 "events:\n"
                 "  - {name: halt, when: {time: 0.1}, then: [{switch: {element: push, to: false}}]}\n"),
      "run.yaml");
  const auto halt = std::ranges::find(scenario.model.events, "halt", &Event::name);
  ASSERT_NE(halt, scenario.model.events.end());
  EXPECT_EQ(scenario.model.element_name(halt->then.at(0).subject), "push");
}

// A box of 2 kg falls on the ground, a little tilted, and rocks; its surface is `shape`.
std::string build_rocking(const std::string& shape) {
  return R"(unlatch: 1
name: rocking
step: {dt: 1 ms, until: 0.5}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: floor, half_space: {normal: [0, 0, 1]}}]}
bodies:
  box: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0.12], attitude: {rotate: [[x, 1 deg], [y, 2 deg]]}, shape: [)" +
         shape + R"(]}
contacts:
  fall: {between: [ground.floor, box], stiffness: 20 kN/m, damping: 1 s/m}
requirements:
  - {id: turn, rate: {body: box}, at_most: 100}
)";
}

TEST(Contacts, AFaceThatRocksOnItsEndsIsUnresolvedAndFeetAreNot) {
  const AnalysedRun face(build_rocking("{box: {size: [0.2, 0.2, 0.2]}}"));
  const auto notice = find_notice(face, "jump");
  ASSERT_TRUE(notice.has_value());
  EXPECT_TRUE(notice->unresolved) << notice->text;
  EXPECT_EQ(notice->subject, "fall");
  EXPECT_FALSE(face.judge("turn").is_resolved());

  std::string feet;
  for (const char* const corner : {"[0.1, 0.1, -0.1]", "[-0.1, 0.1, -0.1]", "[-0.1, -0.1, -0.1]", "[0.1, -0.1, -0.1]"})
    feet += std::string(feet.empty() ? "" : ", ") + "{sphere: {radius: 1 mm, centre: " + corner + "}}";
  const AnalysedRun standing(build_rocking(feet));
  EXPECT_FALSE(find_notice(standing, "jump").has_value());
  EXPECT_TRUE(standing.judge("turn").is_resolved());
}

TEST(Contacts, RoundShapesThatRollHaveNoJumps) {
  for (const char* const shape : {"{capsule: {from: [0, 0, -0.05], to: [0, 0, 0.05], radius: 0.1}}",
                                  "{cylinder: {from: [-0.1, 0, 0], to: [0.1, 0, 0], radius: 0.05}}"}) {
    const AnalysedRun run(std::string(R"(unlatch: 1
name: rolling
step: {dt: 1 ms, until: 0.5}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [{name: floor, half_space: {normal: [0, 0, 1]}}]}
bodies:
  roll: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0.2], velocity: [0, 1, 0], rate: [5, 0, 0], shape: [)") +
                          shape + R"(]}
contacts:
  fall: {between: [ground.floor, roll], stiffness: 20 kN/m, damping: 1 s/m, friction: 0.3}
)");
    EXPECT_GT(run.analysis.list_contacts()[0].totals.impulse, 0) << shape;
    EXPECT_FALSE(find_notice(run, "jump").has_value()) << shape;
  }
}

// A ball that rolls over floors of two boxes, or in the trough of two that stand at an angle.
std::string build_rolling_over(const std::string& floor) {
  return R"(unlatch: 1
name: seam
step: {dt: 1 ms, until: 0.4}
gravity: {uniform: [0, 0, -9.81]}
ground: {shape: [)" +
         floor + R"(]}
bodies:
  ball: {mass: 2 kg, inertia: [0.02, 0.02, 0.02], position: [-0.1, 0, 0.0999], velocity: [0.5, 0, 0], shape: [{sphere: {radius: 0.1}}]}
contacts:
  c: {between: [ground.floor, ball], stiffness: 200 kN/m, damping: 1 s/m}
requirements:
  - {id: force, force: c, take: maximum, at_most: 1 kN}
)";
}

TEST(Contacts, ABallThatTwoShapesOfOneSurfacePushIsUnresolvedAndOneBetweenTwoWallsIsNot) {
  const auto build_box = [](double x, double size, const char* more) {
    return "{group: floor, box: {size: [" + std::to_string(size) + ", 1, 1], centre: [" + std::to_string(x) +
           ", 0, -0.5]" + more + "}}";
  };
  for (const double overlap : {0.0, 0.1}) {
    const AnalysedRun run(build_rolling_over(build_box(-0.5, 1 + 2 * overlap, "") + ", " + build_box(0.5, 1, "")));
    const auto notice = find_notice(run, "seam");
    ASSERT_TRUE(notice.has_value()) << overlap;
    EXPECT_EQ(notice->subject, "c");
    EXPECT_TRUE(notice->unresolved);
    EXPECT_FALSE(run.judge("force").is_resolved());
  }
  // The same two boxes, each with a contact of its own.
  std::string apart = build_rolling_over(build_box(-0.5, 1, "") + ", " + build_box(0.5, 1, ""));
  apart.replace(apart.find("group: floor"), 12, "name: left");
  apart.replace(apart.find("group: floor"), 12, "name: right");
  const std::string contact = "between: [ground.floor, ball], stiffness: 200 kN/m, damping: 1 s/m}";
  apart.replace(
      apart.find(contact), contact.size(),
      "between: [ground.left, ball], stiffness: 200 kN/m, damping: 1 s/m}\n  d: {between: [ground.right, ball], "
      "stiffness: 200 kN/m, damping: 1 s/m}");
  EXPECT_TRUE(find_notice(AnalysedRun(apart), "seam").has_value());

  const AnalysedRun one(build_rolling_over(build_box(0, 2, "")));
  EXPECT_FALSE(find_notice(one, "seam").has_value());
  EXPECT_TRUE(one.judge("force").is_resolved());
  // A wall of 14 degrees of slope begins under the floor: the ball touches both, each with its own normal and point.
  const AnalysedRun trough(build_rolling_over(
      build_box(-0.5, 2, "") +
      ", {group: floor, box: {size: [1, 1, 1], centre: [0.606, 0, -0.364], attitude: {rotate: [[y, -14 deg]]}}}"));
  EXPECT_FALSE(find_notice(trough, "seam").has_value());
}

// A ball of 3 m/s is over both boxes for less than a step of 10 ms; a bar along the seam's normal lies on both.
TEST(Contacts, ASeamIsSeenWithinAStepAndUnderOtherShapesThanSpheres) {
  const std::string floors =
      "{group: floor, box: {size: [1, 1, 1], centre: [-0.5, 0, -0.5]}}, {group: floor, box: {size: [1, 1, 1], centre: "
      "[0.5, 0, -0.5]}}";
  const auto replace = [](std::string text, const std::string& what, const std::string& by) {
    return text.replace(text.find(what), what.size(), by);
  };
  const std::string fast = replace(replace(build_rolling_over(floors), "dt: 1 ms, until: 0.4", "dt: 10 ms, until: 0.1"),
                                   "velocity: [0.5, 0, 0]", "velocity: [3, 0, 0]");
  const AnalysedRun ball(fast);
  const auto notice = find_notice(ball, "seam");
  ASSERT_TRUE(notice.has_value());
  EXPECT_TRUE(notice->unresolved);
  EXPECT_FALSE(
      find_notice(AnalysedRun(replace(fast, ", {group: floor, box: {size: [1, 1, 1], centre: [0.5, 0, -0.5]}}", "")),
                  "seam")
          .has_value());
  const AnalysedRun bar(replace(build_rolling_over(floors), "sphere: {radius: 0.1}",
                                "capsule: {from: [0, -0.05, 0], to: [0, 0.05, 0], radius: 0.1}"));
  EXPECT_TRUE(find_notice(bar, "seam").has_value());
}

}  // namespace
}  // namespace unlatch::test::contact_test
