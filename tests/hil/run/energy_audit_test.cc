// The audit of energy and the notices of a run, against closed forms.
#include "hil/run/audit/energy_audit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "hil/run/notices/notices.h"
#include "hil/run/run.h"
#include "hil/scenario/scenario.h"
#include "tests/hil/scenario/scenario_support.h"

namespace unlatch::test::energy_audit_test {
namespace {

// Error of the balance of a resolved motion, relative to its largest energy: RK4 at h·ω = 0.02 loses (h·ω)⁶/144 a step,
// and the quadrature of powers errs by (h·ω)³/24 of a tick's work, of either sign.
constexpr double kBalances = 1e-6;
constexpr double kExact = 1e-9;  // where every power is linear in time: rounding of a thousand ticks

const std::string kPair = R"(unlatch: 1
name: pair
step: {dt: 0.001, until: 1}
bodies:
  a: {mass: 2, inertia: [1, 1, 1]}
  b: {mass: 2, inertia: [1, 1, 1], position: [1.5, 0, 0]}
)";

struct Audited {
  explicit Audited(const std::string& text)
      : scenario(hil::load_scenario_text(text, "s.yaml")),
        simulation(hil::build_simulation(scenario)),
        watch(scenario, *simulation) {
    watch.update(StepReport{});
    while (simulation->get_time() < scenario.until - 0.5 * scenario.dt) {
      const StepReport report = simulation->step();
      if (report.status != StepStatus::kOk) break;
      watch.update(report);
    }
  }
  [[nodiscard]] const hil::EnergyBalance& energy() const { return watch.get_energy(); }
  [[nodiscard]] double get_work(PowerSource source) const {
    return energy().work[static_cast<std::size_t>(static_cast<int>(source))];
  }
  [[nodiscard]] double get_part() const { return std::abs(energy().largest) / energy().scale; }
  [[nodiscard]] std::vector<std::string> get_names() const {
    std::vector<std::string> names;
    for (const hil::RunNotice& notice : watch.get()) names.push_back(notice.name + " " + notice.subject);
    return names;
  }

  const hil::Scenario scenario;
  const std::unique_ptr<hil::Simulation> simulation;
  hil::NoticeWatch watch;
};

std::string spring(const std::string& stiffness, const std::string& damping) {
  return kPair + "elements:\n  s: {type: spring, between: [a, b], stiffness: " + stiffness + ", damping: " + damping +
         ", free_length: 1}\n";
}

// x'' + 2 ζ ω x' + ω² x = 0 with the reduced mass 1 kg: the remaining energy after t is E(t); the damper has dissipated
// the rest. From rest, with a force that begins as t, the energy grows as t⁴: the trapezoidal rule gives twice of it in
// the first tick.
TEST(EnergyAudit, AForceThatBeginsFromZeroAtRestIsExplained) {
  const Audited run(R"(unlatch: 1
name: sine
step: {dt: 0.0005, until: 0.4}
bodies:
  a: {mass: 500, inertia: [1, 1, 1]}
elements:
  thruster: {type: thrust, body: a, direction: [1, 0, 0], profile: {harmonic: [{amplitude: 1500, frequency: 6, phase: 0}]}}
)");
  EXPECT_THAT(run.get_names(), testing::IsEmpty());
  EXPECT_EQ(run.watch.describe_unresolved(), "");
}

// The work grows as the twelfth power of time: in the first ticks no formula has it from the powers at the ticks, and
// the motion is exact to the truncation of the step.
TEST(EnergyAudit, AForceThatSetsInSharplyAtRestIsNotCalledUnresolved) {
  const Audited run(R"(unlatch: 1
name: sharp
step: {dt: 0.01, until: 0.2}
bodies:
  a: {mass: 2, inertia: [1, 1, 1]}
  b: {mass: 2, inertia: [1, 1, 1], position: [1.5, 0, 0]}
elements:
  push: {type: force, body: a, direction: [1, 0, 0], profile: {expression: "1e8 * time^5 * 1 N/s^5"}}
)");
  EXPECT_THAT(run.get_names(), testing::IsEmpty());
  EXPECT_EQ(run.watch.describe_unresolved(), "");
}

TEST(EnergyAudit, ASpringAndItsDamperBalanceAsTheClosedFormSays) {
  const Audited run(spring("400", "1.2"));
  const double omega = 20, decay = 0.6, swing = std::sqrt(omega * omega - decay * decay), t = 1, x0 = 0.5;
  const double shrunk = x0 * std::exp(-decay * t);
  const double x = shrunk * (std::cos(swing * t) + decay / swing * std::sin(swing * t));
  const double v = -shrunk * omega * omega / swing * std::sin(swing * t);
  const double kinetic = 0.5 * v * v, stored = 0.5 * 400 * x * x, start = 0.5 * 400 * x0 * x0;
  EXPECT_NEAR(run.energy().kinetic, kinetic, 1e-5 * start);  // RK4: (h·ω)⁴/120 of the phase
  EXPECT_NEAR(run.energy().strain, start - stored, 1e-5 * start);
  EXPECT_NEAR(run.get_work(PowerSource::kDampers), kinetic + stored - start, 1e-5 * start);
  EXPECT_LT(run.get_part(), kBalances);
  EXPECT_THAT(run.get_names(), ::testing::IsEmpty());
}

TEST(EnergyAudit, AThrustBesideTheCentreSpinsTheBodyUp) {
  const Audited run(kPair +
                    "elements:\n  jet: {type: thrust, body: a, point: [0, 1, 0], direction: [-2, 0, 0], profile: 1}\n");
  // 2 N at 1 m: 2 N m on 1 kg m², ½ J w² = ½ (2 t)²; and 2 N on 2 kg
  EXPECT_NEAR(0.5 * run.simulation->state().bodies[0].w.z * run.simulation->state().bodies[0].w.z, 2, kExact);
  EXPECT_LT(run.get_part(), kExact);
  EXPECT_THAT(run.get_names(), ::testing::IsEmpty());
}

TEST(EnergyAudit, ALatchTakesHalfTheReducedMassTimesTheSpeedSquared) {
  std::string text = kPair;
  text.replace(text.find("position: [1.5, 0, 0]"), 21, "position: [1.5, 0, 0], velocity: [-1, 0, 0]");
  const Audited run(text + R"(joints:
  latch: {between: [a, b], modes: {open: {kind: free}, held: {kind: weld}}, mode: open}
events:
  - {name: close, when: {time: 0.5}, then: [{set_mode: {joint: latch, mode: held}}]}
)");
  EXPECT_NEAR(run.energy().impulses, -0.5, kExact);  // ½ · 1 kg · (1 m/s)²
  EXPECT_NEAR(run.energy().kinetic, -0.5, kExact);
  EXPECT_LT(run.get_part(), kExact);
}

// Seen from the centre of mass an impulse J does the work J · (what the body gains on the centre, in the mean): at any
// speed of flight.
TEST(EnergyAudit, AnImpulseOfAnActionIsSeenFromTheCentreOfMass) {
  for (const char* speed : {"0", "7000"}) {
    std::string text = kPair;
    for (std::size_t at = text.find("[1, 1, 1]"); at != std::string::npos; at = text.find("[1, 1, 1]", at + 1))
      text.insert(at + 9, std::string(", velocity: [") + speed + ", 0, 0]");
    const Audited run(
        text + "events:\n  - {name: hit, when: {time: 0.305}, then: [{impulse: {body: a, linear: [4, 0, 0]}}]}\n");
    EXPECT_NEAR(run.energy().impulses, 2, kExact) << speed;  // 4 N s · (1 − ½) m/s
    EXPECT_NEAR(run.energy().kinetic, 2, kExact) << speed;
    EXPECT_LT(std::abs(run.energy().largest), kExact) << speed;
  }
}

// Torques of springs and stops about an axis of a joint whose other rotations are free have a potential: they are along
// the gradient of the angle.
TEST(EnergyAudit, SpringsAndStopsAboutAnAxisKeepEnergyWhicheverRotationsAreFree) {
  struct Case {
    std::string mode, rate, velocity;
  };
  const std::string stops =
      "stops:\n  up: {joint: j, axis: rot_y, at_most: 0.05, stiffness: 20 N m/rad}\n"
      "  down: {joint: j, axis: rot_y, at_least: -0.05, stiffness: 20 N m/rad}\n";
  const std::string spring = "elements:\n  s: {type: joint_spring, joint: j, axis: rot_y, stiffness: 5 N m/rad}\n";
  for (const Case& own : {Case{"kind: ball", "[1, 1.2, 1.7]", "[0, 0.85, -0.6]"},
                          {"rows: []", "[1, 1.2, 1.7]", "[0, 0.85, -0.6]"},
                          {"rows: [x, y, z, rot_x]", "[0, 1.2, 1.7]", "[0, 0.85, -0.6]"},
                          {"rows: [x, y, z, rot_z]", "[1, 1.2, 0]", "[0, 0, -0.6]"},
                          {"kind: universal", "[1, 1.2, 0]", "[0, 0, -0.6]"}}) {
    const std::string joint =
        "joints:\n  j: {between: [a, b], point: [0.5, 0, 0], follower_point: [-0.5, 0, 0], "
        "modes: {m: {" +
        own.mode + "}}}\n";
    const std::string bodies =
        "unlatch: 1\nname: swivel\nstep: {dt: 1 ms, until: 1.5 s}\nbodies:\n"
        "  a: {mass: 10 kg, inertia: [1, 1.2, 1.5]}\n"
        "  b: {mass: 1 kg, inertia: [0.03, 0.18, 0.18], position: [1, 0, 0], rate: " +
        own.rate + ", velocity: " + own.velocity + "}\n";
    for (const std::string& element : {stops, spring}) {
      const Audited run(bodies + joint + element);
      EXPECT_LT(run.get_part(), kBalances) << own.mode << '\n' << element;
      EXPECT_NEAR(run.get_work(PowerSource::kMotors), 0, kExact) << own.mode;
    }
  }
}

TEST(EnergyAudit, APusherThatEndsItsStrokeInsideAStepBalances) {
  std::string text = spring("400", "0");
  text.replace(text.find("free_length: 1"), 14, "free_length: 2, push_only: true");
  const Audited run(text);
  EXPECT_NEAR(run.energy().kinetic, 50, 1e-4 * 50);  // ½ · 400 · 0.5²; the stroke ends inside a step: (h·ω)² of it
  EXPECT_LT(run.get_part(), 1e-4);
  EXPECT_THAT(run.get_names(), ::testing::IsEmpty());
}

// Every power is linear in time. A force against the push leaves the depth at the located end above 0 by rounding.
TEST(EnergyAudit, APusherBalancesOnEitherSideOfItsEndsRounding) {
  std::string text = kPair;
  text.insert(text.rfind('}'), ", velocity: [3, 0, 0]");
  text += R"(elements:
  f: {type: force, body: b, direction: [-1, 0, 0], profile: 30}
  p: {type: pusher, between: [a, b], stroke: 0.3, preload: )";
  text.replace(text.find("until: 1"), 8, "until: 0.2");  // it has not returned yet
  for (double preload = 5; preload < 15; preload += 0.25) {
    const Audited run(text + std::to_string(preload) + "}\n");
    EXPECT_NEAR(run.energy().strain, 0.3 * preload, kExact * preload) << preload;
    EXPECT_LT(run.get_part(), kExact) << preload;
  }
}

// A damped stop opens while its spring is still compressed: the energy stored then is lost.
TEST(EnergyAudit, AStopThatLetsGoBeforeItsSpringIsSlackBalances) {
  std::string text = kPair;
  text.insert(text.rfind('}'), ", velocity: [1, 0, 0]");
  text += R"(joints: {j: {between: [a, b], point: [1.5, 0, 0], modes: {slide: {kind: prismatic, axis: x}}}}
stops: {s: {joint: j, axis: x, at_most: 0.1, stiffness: 400, damping: )";
  for (int damping = 5; damping < 45; ++damping) {
    const Audited run(text + std::to_string(damping) + "}}\n");
    EXPECT_LT(run.get_work(PowerSource::kDampers), -0.1) << damping;
    EXPECT_LT(run.get_part(), 1e-4) << damping;  // (h ω)² of the energy, at the two events
  }
}

// A flight speed and a gravity field add nothing to the unexplained energy.
TEST(EnergyAudit, AFlightOfKilometresASecondHidesNoSpring) {
  std::string text = spring("400", "1.2");
  for (const char* body : {"inertia: [1, 1, 1]}", "position: [1.5, 0, 0]}"}) {
    const std::string was = body;
    text.replace(text.find(was), was.size(), was.substr(0, was.size() - 1) + ", velocity: [0, 7600, 0]}");
  }
  const Audited run(text + "gravity: {uniform: [0, 0, -9.81]}\n");
  EXPECT_NEAR(run.energy().scale, 50, 0.1);
  EXPECT_LT(run.get_part(), kBalances);
}

TEST(EnergyAudit, AnUnresolvedSpringDoesNotBalance) {
  const Audited run(spring("6e6", "0"));  // h·ω = 2.4: stable, and damped by the method
  EXPECT_GT(run.get_part(), 0.1);
  EXPECT_NE(run.watch.describe_unresolved(), "");
  EXPECT_THAT(run.get_names(), ::testing::UnorderedElementsAre("spring s", "step a", "step b"));
  EXPECT_EQ(run.watch.get()[0].time, 0);
}

TEST(EnergyAudit, AMarginalSpringIsReportedAndDoesNotFail) {
  const Audited run(spring("9e4", "0"));  // h·ω = 0.3: 5e-6 of the energy a step
  EXPECT_THAT(run.get_names(), ::testing::Contains("spring s"));
  EXPECT_EQ(run.watch.describe_unresolved(), "");
}

TEST(Notices, ABodyThatTurnsFarInAStepIsReportedOnceWithItsFirstTime) {
  std::string text = kPair;
  text.replace(text.find("inertia: [1, 1, 1]}"), 19, "inertia: [1, 1, 1], rate: [0, 0, 190]}");
  // 20 rad/s² from 190 to 210 rad/s: 0.2 rad a step at 0.5 s
  const Audited run(text + "elements:\n  jet: {type: torque, body: a, direction: [0, 0, 1], profile: 20}\n");
  ASSERT_EQ(run.watch.get().size(), 1u);
  EXPECT_EQ(run.watch.get()[0].name, "rotation");
  EXPECT_NEAR(run.watch.get()[0].time, 0.5, 0.0021);
}

TEST(Notices, ALoopThatSwingsWithinItsDelayIsReported) {
  const std::string text = kPair + R"(channels:
  valve: {initial: 0, range: [-1, 1], safe: 0}
elements:
  jet: {type: thrust, body: a, direction: [1, 0, 0], profile: 1, channel: valve}
)";
  for (const auto& [ticks, is_reported] : {std::pair{4, true}, {40, false}}) {
    const hil::Scenario scenario = hil::load_scenario_text(text, "s.yaml");
    const auto simulation = hil::build_simulation(scenario);
    hil::NoticeWatch watch(scenario, *simulation);
    watch.update(StepReport{});
    for (int tick = 0; tick < 400; ++tick) {
      simulation->set_channel(0, (tick / ticks) % 2 == 0 ? 1 : -1);
      watch.update(simulation->step());
    }
    EXPECT_EQ(watch.get().size(), is_reported ? 1u : 0u) << ticks;
    for (const hil::RunNotice& notice : watch.get()) EXPECT_EQ(notice.name + " " + notice.subject, "command valve");
    EXPECT_LT(std::abs(watch.get_energy().unexplained), kExact * watch.get_energy().scale + 1e-12);
  }
}

}  // namespace
}  // namespace unlatch::test::energy_audit_test
