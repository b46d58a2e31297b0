// Springs and modes whose period the step does not resolve, beside a motion that hides them from the audit of bodies,
// against the same springs with a step that does.
#include "hil/run/notices/implicit_audit.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::implicit_audit_test {
namespace {

// A panel of 1 kg on a spring of 1e6 N/m (0.999 kg of reduced mass), both of which accelerate at 10 m/s²; the panel has
// a force of its own as well. Another body stands apart.
std::string push_panel(const std::string& force, const std::string& dt, const std::string& spring = "",
                       const std::string& more = "") {
  return "unlatch: 1\nname: panel\nstep: {dt: " + dt + R"(, until: 1}
bodies:
  hub: {mass: 1000, inertia: [1, 1, 1]}
  panel: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
  other: {mass: 1000, inertia: [1, 1, 1], position: [0, 9, 0]}
joints:
  rail: {between: [hub, panel], point: [1, 0, 0], mode: slides,
         modes: {slides: {kind: prismatic, axis: x}, held: {kind: weld}}}
elements:
  spring: {type: joint_spring, joint: rail, axis: x, stiffness: 1e6)" +
         spring + R"(}
  push: {type: force, body: panel, frame: world, direction: [1, 0, 0], profile: {expression: "10 N + )" +
         force + R"("}}
  thrust: {type: force, body: hub, frame: world, direction: [1, 0, 0], profile: 10 kN}
requirements:
  - {id: deflection, displacement: {joint: rail, axis: x}, take: peak, at_most: 1 m}
  - {id: speed, speed: {joint: rail, axis: x}, take: peak, at_most: 1 m/s}
  - {id: apart, velocity: {body: panel, relative_to: hub}, take: peak, at_most: 1 m/s}
  - {id: reaction, reaction: {joint: rail, row: y}, at_most: 1 kN}
  - {id: far, position: {body: other, along: [0, 1, 0]}, take: final, at_least: 1 m}
)" + more;
}

const char* const kJump = "if_less(time, 0.5037 s, 0 N, 100 N)";
const char* const kSmooth = "100 N * time^2 * (3 - 2 * time / (1 s)) / (1 s^2)";

std::vector<hil::RunNotice> list_overshoots(const AnalysedRun& run) {
  std::vector<hil::RunNotice> notices;
  for (const hil::RunNotice& notice : run.analysis.accuracy().get())
    if (notice.name == "overshoot") notices.push_back(notice);
  return notices;
}

bool is_unresolved(const AnalysedRun& run, const std::string& id) { return !run.judge(id).unresolved.empty(); }

// The step that a notice proposes, s.
std::string find_step(const std::string& text) {
  const std::string before = "a step of ";
  const std::size_t from = text.find(before) + before.size();
  return text.substr(from, text.find(" s ", from) - from) + " s";
}

// Undamped it swings to twice its mean deflection, and the step keeps the mean.
TEST(ImplicitAudit, AJumpBesideALargeMotionIsUnresolvedAndTheProposedStepSuffices) {
  constexpr double kTwice = 2 * 100 * (1000.0 / 1001) / 1e6;  // m: of the part of the force that the hub bears
  for (const char* const dt : {"10 ms", "2 ms"}) {
    const AnalysedRun run(push_panel(kJump, dt));
    ASSERT_EQ(list_overshoots(run).size(), 1U) << dt;
    const hil::RunNotice notice = list_overshoots(run).front();
    EXPECT_EQ(notice.subject, "spring");
    EXPECT_TRUE(notice.unresolved);
    EXPECT_NEAR(notice.time, 0.5037, 0.011);
    for (const char* const id : {"deflection", "speed", "apart", "reaction"}) EXPECT_TRUE(is_unresolved(run, id)) << id;
    EXPECT_FALSE(is_unresolved(run, "far"));
    EXPECT_LT(run.judge("deflection").value, 0.99 * kTwice);
    const AnalysedRun fine(push_panel(kJump, find_step(notice.text)));
    EXPECT_TRUE(list_overshoots(fine).empty());
    EXPECT_FALSE(is_unresolved(fine, "reaction")) << fine.judge("reaction").unresolved;
    EXPECT_NEAR(fine.judge("deflection").value, kTwice, 0.005 * kTwice);
  }
}

// So stiff that two half steps forget the overshoot as well as one: h·ω = 1000.
TEST(ImplicitAudit, AnOvershootThatHalfStepsDoNotShowIsUnresolved) {
  std::string stiff = push_panel(kJump, "10 ms");
  stiff.replace(stiff.find("stiffness: 1e6"), 14, "stiffness: 1e10");
  EXPECT_TRUE(is_unresolved(AnalysedRun(stiff), "deflection"));
}

// A force that grows smoothly: the deflection is right, the speed is not, nor is what reads it.
TEST(ImplicitAudit, UnderASmoothForceTheSpeedAloneIsUnresolved) {
  const AnalysedRun run(push_panel(kSmooth, "10 ms"));
  EXPECT_NEAR(run.judge("deflection").value, 1e-4, 3e-7);
  EXPECT_FALSE(is_unresolved(run, "deflection")) << run.judge("deflection").unresolved;
  EXPECT_GT(run.judge("speed").value, 3 * 1.5e-4);
  EXPECT_TRUE(is_unresolved(run, "speed"));
  EXPECT_TRUE(is_unresolved(run, "apart"));
  ASSERT_EQ(list_overshoots(run).size(), 1U);
  EXPECT_FALSE(list_overshoots(run).front().unresolved);
  EXPECT_TRUE(run.analysis.accuracy().describe_unresolved().empty());
  const AnalysedRun read(push_panel(kSmooth, "10 ms", "", "quantities: {pace: {speed: {joint: rail, axis: x}}}\n"));
  EXPECT_TRUE(is_unresolved(read, "deflection"));
  const AnalysedRun fine(push_panel(kSmooth, find_step(list_overshoots(run).front().text)));
  EXPECT_FALSE(is_unresolved(fine, "speed"));
  EXPECT_NEAR(fine.judge("speed").value, 1.5e-4, 0.1 * 1.5e-4);  // it swings by as much as its start is abrupt
}

// Critically damped it has no overshoot, and the method makes one of its own.
TEST(ImplicitAudit, ADampedSpringIsUnresolvedAtAJumpAlone) {
  const std::string damping = ", damping: 2100";
  const AnalysedRun jump(push_panel(kJump, "10 ms", damping)), fine(push_panel(kJump, "0.1 ms", damping));
  EXPECT_FALSE(is_unresolved(fine, "deflection")) << fine.judge("deflection").unresolved;
  EXPECT_GT(jump.judge("deflection").value, 1.1 * fine.judge("deflection").value);
  EXPECT_TRUE(is_unresolved(jump, "deflection"));
  const AnalysedRun smooth(push_panel(kSmooth, "10 ms", damping));
  EXPECT_FALSE(is_unresolved(smooth, "deflection")) << smooth.judge("deflection").unresolved;
  EXPECT_NEAR(smooth.judge("deflection").value, 1e-4, 3e-7);
}

TEST(ImplicitAudit, ASpringThatIsOffOrHeldHasNoOvershoot) {
  const std::string off = "events: [{name: release, when: {time: 0.2}, then: [{switch: {element: spring, to: 0}}]}]\n";
  const std::string held = "events: [{name: hold, when: {time: 0.2}, then: [{set_mode: {joint: rail, mode: held}}]}]\n";
  for (const std::string& event : {off, held}) {
    const AnalysedRun run(push_panel(kJump, "10 ms", "", event));
    EXPECT_TRUE(list_overshoots(run).empty()) << event;
  }
}

// A cross of 8 kg whose middle is pushed: its one mode of 200 Hz bends the arms back. Deflection of the tip from the
// middle under a steady force F: F / (4 ω²), ω = 400 π.
std::string push_cross(const std::string& force, const std::string& dt, double damping = 0,
                       const std::string& more = "") {
  const std::filesystem::path folder = ::testing::TempDir() + "implicit_audit_" + std::to_string(::getpid());
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "cross.modes") << R"(unlatch modes 1
frequencies 200
marker tip 1 0 0
0 0 1   0 0 0
marker middle 0 0 0
0 0 -1  0 0 0
points 5
1   1 0 0   0 0 1
1  -1 0 0   0 0 1
1   0 1 0   0 0 1
1   0 -1 0  0 0 1
4   0 0 0   0 0 -1
end
)";
  std::ofstream(folder / "cross.yaml") << "unlatch: 1\nname: cross\nstep: {dt: " << dt << ", until: 0.7}\n"
                                       << "bodies:\n  cross: {flexible: {modes: cross.modes, damping: " << damping
                                       << R"(}, origin: [0, 0, 0]}
  tip: {marker: {of: cross, at: tip}}
  middle: {marker: {of: cross, at: middle}}
  other: {mass: 1000, inertia: [1, 1, 1], position: [0, 9, 0]}
elements:
  push: {type: force, body: middle, frame: world, direction: [0, 0, 1], profile: {expression: ")"
                                       << force << R"("}}
requirements:
  - {id: deflection, position: {body: tip, relative_to: middle, along: [0, 0, 1]}, take: minimum, at_least: -1 m}
  - {id: apart, velocity: {body: tip, relative_to: middle}, take: peak, at_most: 1 m/s}
  - {id: far, position: {body: other, along: [0, 1, 0]}, take: final, at_least: 1 m}
)" << more;
  const std::string text = hil::load_scenario(folder / "cross.yaml").text;  // with the modes
  std::filesystem::remove_all(folder);
  return text;
}

constexpr double kSteady = 100 / (4 * 400 * 400 * std::numbers::pi * std::numbers::pi);  // m, of 100 N

// Of the damped one the overshoot is that of its own damping.
TEST(ImplicitAudit, AModeThatOvershootsIsUnresolvedAndTheProposedStepSuffices) {
  for (const double damping : {0.0, 0.2}) {
    const double least = -kSteady * (1 + std::exp(-std::numbers::pi * damping / std::sqrt(1 - damping * damping)));
    const AnalysedRun run(push_cross(kJump, "10 ms", damping));
    ASSERT_EQ(list_overshoots(run).size(), 1U) << damping;
    const hil::RunNotice notice = list_overshoots(run).front();
    EXPECT_EQ(notice.subject, "cross");
    EXPECT_TRUE(notice.unresolved);
    EXPECT_NEAR(notice.time, 0.5037, 0.011);
    EXPECT_TRUE(is_unresolved(run, "deflection"));
    EXPECT_TRUE(is_unresolved(run, "apart"));
    EXPECT_FALSE(is_unresolved(run, "far"));
    if (damping == 0) {
      EXPECT_GT(run.judge("deflection").value, 0.9 * least);  // too little by a tenth or more
    }
    const AnalysedRun fine(push_cross(kJump, find_step(notice.text), damping));
    EXPECT_TRUE(list_overshoots(fine).empty());
    EXPECT_FALSE(is_unresolved(fine, "deflection")) << fine.judge("deflection").unresolved;
    EXPECT_NEAR(fine.judge("deflection").value, least, 0.005 * kSteady);
  }
}

// The deflection is right, how fast it changes is not: by ten times, since the method swings at the rate of the step.
TEST(ImplicitAudit, UnderASmoothForceTheSpeedOfAModeAloneIsUnresolved) {
  constexpr double kFastest = 1.5 * kSteady;  // m/s, in the middle of the second
  const AnalysedRun run(push_cross(kSmooth, "10 ms"));
  const double last = run.judge("deflection").value;
  EXPECT_NEAR(last, -kSteady * 0.49 * 1.6, 0.01 * kSteady);  // half of what the audit lets pass
  EXPECT_FALSE(is_unresolved(run, "deflection")) << run.judge("deflection").unresolved;
  EXPECT_GT(run.judge("apart").value, 3 * kFastest);
  EXPECT_TRUE(is_unresolved(run, "apart"));
  ASSERT_EQ(list_overshoots(run).size(), 1U);
  EXPECT_FALSE(list_overshoots(run).front().unresolved);
  EXPECT_TRUE(run.analysis.accuracy().describe_unresolved().empty());
  const std::string meter = "sensors: {meter: {type: acceleration, body: tip}}\n";
  EXPECT_TRUE(is_unresolved(AnalysedRun(push_cross(kSmooth, "10 ms", 0, meter)), "deflection"));
  const AnalysedRun fine(push_cross(kSmooth, find_step(list_overshoots(run).front().text)));
  EXPECT_FALSE(is_unresolved(fine, "apart")) << fine.judge("apart").unresolved;
  EXPECT_NEAR(fine.judge("apart").value, kFastest, 0.02 * kFastest);
}

// A force that the spring's own speed decides, and one of it: the first depends on a speed that is wrong.
TEST(ImplicitAudit, WhatReadsTheSpeedInOtherWordsDependsOnIt) {
  const std::string reads[] = {
      "quantities: {pace: {length_rate: {element: spring}}}\n",
      "quantities: {pace: {velocity: {body: panel, relative_to: hub}}}\n",
      "quantities: {load: {reaction_force: {joint: rail}}}\n",
      "events: [{name: fast, when: {quantity: {velocity: {body: panel, relative_to: hub}}, above: 1 km/s}}]\n",
  };
  for (const std::string& read : reads)
    EXPECT_TRUE(is_unresolved(AnalysedRun(push_panel(kSmooth, "10 ms", "", read)), "deflection")) << read;
  const std::string others[] = {"quantities: {pace: {force: {element: spring}}}\n",
                                "quantities: {pace: {velocity: {body: other}}}\n",
                                "quantities: {place: {position: {body: panel, relative_to: hub}}}\n"};
  for (const std::string& other : others) {
    const AnalysedRun run(push_panel(kSmooth, "10 ms", "", other));
    EXPECT_FALSE(is_unresolved(run, "deflection")) << other;
    EXPECT_TRUE(is_unresolved(run, "reaction"));
  }
}

// Elements whose force the speed decides, beside the spring or between bodies on its two sides, and a joint that locks.
TEST(ImplicitAudit, WhatActsByTheSpeedDependsOnIt) {
  const std::string rider = "  rider: {mass: 1, inertia: [1, 1, 1], position: [0, 1, 0]}\n";
  const std::string weld = "  seat: {between: [hub, rider], point: [0, 1, 0], modes: {held: {kind: weld}}}\n";
  const auto build = [&](const std::string& element, const std::string& more = "") {
    std::string text = push_panel(kSmooth, "10 ms", element.empty() ? "" : "}\n  reader: {" + element, more);
    for (const auto& [key, value] : {std::pair{"bodies:\n", rider}, std::pair{"joints:\n", weld}})
      text.insert(text.find(key) + std::string(key).size(), value);
    return text;
  };
  const std::string balls[] = {"panel: {", "shape: [{name: ball, sphere: {centre: [0, 0, 0], radius: 0.1}}], ",
                               "rider: {", "shape: [{name: ball, sphere: {centre: [0, 0, 0], radius: 0.1}}], "};
  const auto build_contact = [&](const std::string& law) {
    std::string text = build("", "contacts: {bump: {between: [panel, rider], stiffness: 1 kN/m" + law + "}}\n");
    for (int i = 0; i < 4; i += 2) text.insert(text.find(balls[i]) + balls[i].size(), balls[i + 1]);
    return text;
  };
  // A second rail beside the first one, between bodies that it joins already.
  const auto build_lock = [&](const std::string& time) {
    std::string text = build(
        "", "events: [{name: grip, when: {time: " + time + "}, then: [{set_mode: {joint: grip, mode: slides}}]}]\n");
    const std::string grip =
        "  grip: {between: [rider, panel], point: [1, 0, 0], follower_point: [0, 0, 0], mode: free,\n"
        "         modes: {free: {kind: free}, slides: {kind: prismatic, axis: x}}}\n";
    return text.insert(text.find("joints:\n") + std::string("joints:\n").size(), grip);
  };
  const std::string readers[] = {
      build("type: joint_friction, joint: rail, axis: x, coefficient: 0.1, speed: 10 m/s"),
      build("type: joint_spring, joint: rail, axis: x, damping: 1 N s/m"),
      build("type: spring, between: [rider, panel], stiffness: 1 N/m, damping: 0.1 N s/m"),
      build_contact(", friction: 0.1"),
      build_contact(", damping: 0.1 s/m"),
      build_lock("0.5 s"),
      build("", "quantities: {pace: {velocity: {body: panel, relative_to: rider}}}\n"),
  };
  for (const std::string& reader : readers) EXPECT_TRUE(is_unresolved(AnalysedRun(reader), "deflection")) << reader;
  const std::string others[] = {
      build(""),
      build("type: joint_friction, joint: rail, axis: x, coefficient: 0"),
      build("type: spring, between: [rider, panel], stiffness: 1 N/m"),
      build("type: spring, between: [hub, rider], stiffness: 1 N/m, damping: 0.1 N s/m"),
      build_contact(""),
      build_lock("2 s"),
      build("", "quantities: {pace: {velocity: {body: rider, relative_to: hub}}}\n"),
  };
  for (const std::string& other : others) {
    const AnalysedRun run(other);
    EXPECT_FALSE(is_unresolved(run, "deflection")) << other << run.judge("deflection").unresolved;
    EXPECT_TRUE(is_unresolved(run, "speed"));
  }
}

// The joint holds from 0.5 s on, and the spring has no motion any more; the speed of before was wrong.
TEST(ImplicitAudit, ALockHidesNoErrorOfTheSpeedBeforeIt) {
  const AnalysedRun run(push_panel(kSmooth, "10 ms", "",
                                   "events: [{name: hold, when: {time: 0.5 s}, then: [{set_mode: {joint: rail, mode: "
                                   "held}}]}]\n"));
  EXPECT_GT(run.judge("speed").value, 3 * 1.5e-4);
  EXPECT_LE(run.judge("speed").time, 0.5);
  EXPECT_TRUE(is_unresolved(run, "speed"));
}

}  // namespace
}  // namespace unlatch::test::implicit_audit_test
