// Greatest values of a run whose forces jump, or turn, at a tick or within a step: each piece of the motion counts by
// itself, and no polynomial goes through knots on both sides.
#include <cmath>
#include <cstring>

#include "tests/hil/run/analysed_run.h"

namespace unlatch::test::corners_test {
namespace {

constexpr double kExact = 1e-9;  // relative, of forces that are linear in time between their corners

struct Pushed {
  const char* what;
  const char* tables;   // of the scenario
  const char* profile;  // of the force, N
  double greatest;      // N
};

// A block that a weld holds against the force, and a free one that it pushes.
std::string push(const Pushed& by, const char* dt) {
  return std::string("unlatch: 1\nname: corners\nstep: {dt: ") + dt +
         ", until: 1 s}\n"
         "bodies:\n  held: {mass: 2, inertia: [1, 1, 1]}\n  free: {mass: 2, inertia: [1, 1, 1], position: [0, 9, 0], "
         "velocity: [1, 0, 0]}\n"
         "joints: {root: {between: [ground, held], modes: {welded: {kind: weld}}}}\n" +
         by.tables +
         "quantities:\n  x: {position: {body: free, component: x}}\n  felt: {acceleration: {body: free, component: "
         "x}}\n"
         "elements:\n  on_held: {type: force, body: held, frame: world, direction: [1, 0, 0], profile: " +
         by.profile +
         "}\n  on_free: {type: force, body: free, frame: world, direction: [1, 0, 0], profile: " + by.profile +
         "}\n"
         "requirements:\n"
         "  - {id: held, reaction: {joint: root, row: x}, take: peak, at_most: 1000 N}\n"
         "  - {id: felt, quantity: felt, at_most: 1000 m/s2}\n";
}

const Pushed kPushed[] = {
    {"a jump up within a step", "", "{expression: \"if_less(time, 0.5037 s, 1 N, 3 N)\"}", 3},
    {"a jump down within a step", "", "{expression: \"if_less(time, 0.5037 s, 3 N, 1 N)\"}", 3},
    {"a jump up at a tick", "", "{expression: \"if_less(time, 0.5 s, 1 N, 3 N)\"}", 3},
    {"a jump down at a tick", "", "{expression: \"if_less(time, 0.5 s, 3 N, 1 N)\"}", 3},
    {"a jump at a place", "", "{expression: \"if_less(x, 0.3 m, 1 N, 3 N)\"}", 3},
    {"a ramp shorter than a step",
     "tables: {tab: {axes: {s: {at: [0, 0.5037, 0.5052, 1], unit: s}}, values: [1, 1, 3, 3], unit: N}}\n",
     "{expression: tab(time)}", 3},
    {"a ramp from tick to tick",
     "tables: {tab: {axes: {s: {at: [0, 0.5, 0.52, 1], unit: s}}, values: [1, 1, 3, 3], unit: N}}\n",
     "{expression: tab(time)}", 3},
    {"a peak within a step", "tables: {tab: {axes: {s: {at: [0, 0.5037, 1], unit: s}}, values: [1, 3, 2], unit: N}}\n",
     "{expression: tab(time)}", 3},
    {"a limit", "", "{expression: \"min(3 N, 1 N + 8 N/s * max(0 s, time - 0.3037 s))\"}", 3},
    {"a profile's ramp shorter than a step", "", "{table: {times: [0, 0.5037, 0.5052, 1], values: [1, 1, 3, 3]}}", 3},
    {"a profile's peak within a step", "", "{table: {times: [0, 0.5037, 1], values: [1, 3, 2]}}", 3},
    {"a profile's peaks within a step", "",
     "{table: {times: [0, 0.5037, 0.5043, 0.5056, 1], values: [1, 2.5, 1, 3, 2]}}", 3},
    {"a profile's ramp from tick to tick", "", "{table: {times: [0, 0.5, 0.52, 1], values: [1, 1, 3, 3]}}", 3},
};

TEST(Corners, GreatestReactionsAndAccelerationsAreThoseOfThePieces) {
  for (const Pushed& by : kPushed)
    for (const char* dt : {"20 ms", "10 ms", "1 ms"}) {
      const AnalysedRun run(push(by, dt));
      EXPECT_NEAR(std::abs(run.analysis.get_peak(0, kX).value), by.greatest, kExact) << by.what << ", " << dt;
      EXPECT_NEAR(std::abs(run.judge("held").value), by.greatest, kExact) << by.what << ", " << dt;
      EXPECT_NEAR(run.judge("felt").value, by.greatest / 2, kExact) << by.what << ", " << dt;
      for (const hil::RunNotice& notice : run.analysis.accuracy().get())
        ADD_FAILURE() << by.what << ", " << dt << ": " << notice.name << " " << notice.text;
    }
}

// Under a force that is linear between its points, also where it is switched on within a step, the rule of the step is
// exact: m v = ∫ F dt, m x = ∫ (1 - t) F dt, from 0 to 1 s.
TEST(Corners, StepsAreSplitAtThePointsOfTablesOverTime) {
  const double times[] = {0, 0.1037, 0.1043, 0.3, 0.45}, values[] = {1, 30, 2, 7, 0};
  for (const double on : {0.0, 0.25, 0.2561})
    for (const char* dt : {"20 ms", "10 ms", "1 ms"}) {
      const std::string text =
          std::string("unlatch: 1\nname: points\nstep: {dt: ") + dt +
          ", until: 1 s}\nbodies:\n  free: {mass: 2, inertia: [1, 1, 1]}\n"
          "elements:\n  push: {type: force, body: free, frame: world, direction: [1, 0, 0], "
          "enabled: false, profile: {table: {times: [0, 0.1037, 0.1043, 0.3, 0.45], values: [1, 30, 2, 7, "
          "0]}}}\nevents:\n  - {name: start, when: {time: " +
          std::to_string(on) + "}, then: [{switch: {element: push, to: true}}]}\n";
      double impulse = 0, moment = 0;
      for (int i = 1; i < 5; ++i) {
        const double h = times[i] - times[i - 1], a = values[i - 1], b = values[i], left = 1 - on - times[i - 1];
        impulse += h * (a + b) / 2;
        moment += h * left * (a + b) / 2 - h * h * (a / 6 + b / 3);
      }
      const auto simulation = hil::build_simulation(hil::load_scenario_text(text, "points.yaml"));
      while (simulation->get_time() < 1 - 1e-9) ASSERT_EQ(simulation->step().status, StepStatus::kOk);
      EXPECT_NEAR(simulation->state().bodies[0].v.x, impulse / 2, 1e-12) << on << ", " << dt;
      EXPECT_NEAR(simulation->state().bodies[0].p.x, moment / 2, 1e-12) << on << ", " << dt;
    }
}

// A force that a ramp switches on and another one down again, the second within the time of its table: F is quadratic
// in time in each piece, which the rule of the step integrates exactly.
TEST(Corners, StepsAreSplitAtTheEndsOfRamps) {
  constexpr double kUp = 0.2343, kDown = 0.1117, kLow = 0.25, kFirst = 6, kSlope = 4;  // s, s, 1, N, N/s
  for (const double on : {0.1, 0.1029})
    for (const char* dt : {"20 ms", "10 ms", "1 ms"}) {
      const std::string text =
          std::string("unlatch: 1\nname: ramps\nstep: {dt: ") + dt +
          ", until: 1 s}\nbodies:\n  free: {mass: 2, inertia: [1, 1, 1], position: [0, 9, 0]}\n"
          "  held: {mass: 2, inertia: [1, 1, 1]}\n"
          "joints: {root: {between: [ground, held], modes: {welded: {kind: weld}}}}\nelements:\n"
          "  push: {type: force, body: free, frame: world, direction: [1, 0, 0], enabled: false, "
          "profile: {table: {times: [0, 1], values: [6, 2]}}}\n"
          "  hold: {type: force, body: held, frame: world, direction: [1, 0, 0], enabled: false, "
          "profile: {table: {times: [0, 1], values: [6, 2]}}}\nevents:\n"
          "  - {name: up, when: {time: " +
          std::to_string(on) +
          "}, then: [{ramp: {element: push, to: 1, over: 234.3 ms}}, {ramp: {element: hold, to: 1, over: 234.3 ms}}]}\n"
          "  - {name: down, when: {time: 0.5003}, then: [{ramp: {element: push, to: 0.25, over: 111.7 ms}}]}\n"
          "requirements:\n  - {id: held, reaction: {joint: root, row: x}, take: peak, at_most: 1000 N}\n";
      const double corners[] = {on, on + kUp, 0.5003, 0.5003 + kDown, 1};
      const double scales[] = {0, 1, 1, kLow, kLow};
      double impulse = 0;  // by Simpson's rule, which is exact for a square
      for (int i = 0; i < 4; ++i) {
        const auto get_force = [&](double part) {
          const double t = corners[i] + part * (corners[i + 1] - corners[i]);
          return (scales[i] + part * (scales[i + 1] - scales[i])) * (kFirst - kSlope * (t - on));
        };
        impulse += (corners[i + 1] - corners[i]) * (get_force(0) + 4 * get_force(0.5) + get_force(1)) / 6;
      }
      const AnalysedRun run(text);
      EXPECT_NEAR(run.simulation->state().bodies[0].v.x, impulse / 2, 1e-12) << on << ", " << dt;
      EXPECT_NEAR(std::abs(run.judge("held").value), kFirst - kSlope * kUp, kExact) << on << ", " << dt;
    }
}

// The drag of a ball: by its coefficient, and by forces whose laws read the air.
constexpr const char* kByAerodynamics = "elements: {air: {type: aerodynamics, body: ball, area: 0.3 m2, drag: 1}}\n";
constexpr const char* kByLaws =
    "quantities:\n  density: {density: ball}\n  speed: {airspeed: ball}\n"
    "  u: {air_velocity: {body: ball, component: x}}\n  v: {air_velocity: {body: ball, component: y}}\n"
    "  w: {air_velocity: {body: ball, component: z}}\n  drag: {expression: \"-0.15 m2 * density * speed\"}\n"
    "elements:\n  x: {type: force, body: ball, direction: [1, 0, 0], profile: {expression: drag * u}}\n"
    "  y: {type: force, body: ball, direction: [0, 1, 0], profile: {expression: drag * v}}\n"
    "  z: {type: force, body: ball, direction: [0, 0, 1], profile: {expression: drag * w}}\n";

// A ball that falls through rows of the wind and through the border of two layers of the air at 11 km.
std::string build_fall(const char* dt, const char* drag) {
  return std::string("unlatch: 1\nname: fall\nstep: {dt: ") + dt +
         ", until: 8 s}\nenvironment: {planet: wgs84, atmosphere: us1976, origin: start, wind: {altitude: [9.7 km, "
         "10.1 "
         "km, 10.6 km, 11.4 km, 11.5 km], north: [5, -20, 10, 30, -10], east: [0, 15, -25, 20, 40]}}\n"
         "start: {latitude: 40 deg, altitude: 12 km, velocity: [0, 0, 300]}\n"
         "bodies: {ball: {mass: 20, inertia: [1, 1, 1]}}\n" +
         drag;
}

Vec3 fall_through_wind(const char* dt, const char* drag) {
  const auto simulation = hil::build_simulation(hil::load_scenario_text(build_fall(dt, drag), "fall.yaml"));
  while (simulation->get_time() < 8 - 1e-9) EXPECT_EQ(simulation->step().status, StepStatus::kOk);
  return simulation->state().bodies[0].v;
}

TEST(Corners, StepsAreSplitAtTheRowsOfTheWindAndAtTheBordersOfTheAirsLayers) {
  constexpr double kFourthOrder = 12;  // of 16: what halving the step divides its error by
  for (const char* drag : {kByAerodynamics, kByLaws}) {
    const Vec3 exact = fall_through_wind("0.625 ms", drag);
    double before = 0;
    for (const char* dt : {"40 ms", "20 ms", "10 ms"}) {
      const double error = norm(fall_through_wind(dt, drag) - exact);
      EXPECT_GT(error, 1e-11) << dt;  // m/s, above rounding
      if (before > 0) {
        EXPECT_LT(error, before / kFourthOrder) << dt << ": " << error << " after " << before << " " << drag;
      }
      before = error;
    }
  }
}

// 5 kg that a force over its travel pushes: between its bodies along a joint, or between points of them.
TEST(Corners, StepsAreSplitAtTheKnotsOfATableOverTravel) {
  const std::string
      body =
          "unlatch: 1\nname: travel\nstep: {dt: 2 ms, until: 100 ms}\nbodies:\n  b: {mass: 5 kg, inertia: [1, 1, 1], "
          "position: [0.3, 0, 0]}\n",
      joint =
          "joints:\n  sl: {between: [ground, b], point: [0.3, 0, 0], modes: {s: {kind: prismatic, "
          "axis: x}}}\n",
      table = "stroke: 0.15, table: {travel: [0, 0.05, 0.08, 0.15], force: [2000, 500, 2500, 300]}}\n",
      rest =
          "quantities:\n  fp: {force: push}\n"
          "requirements:\n"
          "  - {id: force, force: push, take: maximum, at_most: 10 kN}\n"
          "  - {id: acceleration, acceleration: b, at_most: 1e4}\n"
          "  - {id: expression, expression: fp, at_most: 10 kN}\n"
          "  - {id: speed, velocity: {body: b}, at: \"stroke_end:push\", at_most: 1e4}\n";
  for (const char* push : {"elements:\n  push: {type: pusher, joint: sl, axis: x, ",
                           "elements:\n  push: {type: pusher, between: [ground, b], point: [0.1, 0, 0], "}) {
    const AnalysedRun run(body + joint + push + table + rest);
    constexpr double kLocated = 1e-6;  // relative: the corner is found to that part of a sub-step
    for (const auto& [id, value] : {std::pair{"force", 2500.0},
                                    {"acceleration", 500.0},
                                    {"expression", 2500.0},
                                    {"speed", std::sqrt(2 * 205.5 / 5)}}) {
      const hil::Verdict verdict = run.judge(id);
      EXPECT_NEAR(verdict.value, value, kLocated * value) << push << id;
      EXPECT_FALSE(verdict.is_uncertain()) << push << id;
    }
  }
}

// What the weld holds, just before and just after a jump that a step is split at, and that lies on a tick.
TEST(Corners, AJumpHasItsValuesOnBothSides) {
  for (const char* when : {"0.5", "0.5037"}) {
    const std::string law = std::string("{expression: \"if_less(time, ") + when + " s, 1 N, 3 N)\"}";
    const hil::Scenario scenario = hil::load_scenario_text(push({"", "", law.c_str(), 3}, "10 ms"), "corners.yaml");
    const auto simulation = hil::build_simulation(scenario);
    simulation->keep_motion();
    std::vector<double> forces;
    while (simulation->get_tick() < 60) {
      ASSERT_EQ(simulation->step().status, StepStatus::kOk);
      for (const MotionKnot& knot : simulation->get_motion())
        if (std::abs(knot.time - std::atof(when)) < 1e-9) forces.push_back(std::abs(knot.multipliers[kX]));
    }
    ASSERT_EQ(forces.size(), 2u) << when;
    EXPECT_NEAR(forces[0], 1, kExact) << when;
    EXPECT_NEAR(forces[1], 3, kExact) << when;
  }
}

// The same bits with and without a log of the motion, which evaluates a jump's end once more.
void expect_same_bits_when_logged(const std::string& text, const std::string& what) {
  const hil::Scenario scenario = hil::load_scenario_text(text, "corners.yaml");
  const auto alone = hil::build_simulation(scenario), logged = hil::build_simulation(scenario);
  logged->keep_motion();
  while (alone->get_time() < scenario.until - 0.5 * scenario.dt) {
    ASSERT_EQ(alone->step().status, StepStatus::kOk);
    ASSERT_EQ(logged->step().status, StepStatus::kOk);
    ASSERT_EQ(alone->calc_hash(), logged->calc_hash()) << what;
    const auto a = alone->workspace().quantities, b = logged->workspace().quantities;
    ASSERT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0) << what << alone->get_tick();
  }
}

TEST(Corners, LoggingThemChangesNoBit) {
  for (const Pushed& by : kPushed) expect_same_bits_when_logged(push(by, "10 ms"), by.what);
  for (const char* drag : {kByAerodynamics, kByLaws})
    expect_same_bits_when_logged(build_fall("10 ms", drag), "a fall through rows of the wind");
}

// A law that no force reads is not located, but the polynomial through its values does not pass its jump either.
TEST(Corners, OfALawThatNoForceReadsLeaveItsGreatestValueAsItIs) {
  for (const char* law :
       {"if_less(x, 0.3 m, 1, 3)", "if_less(x, 0.3 m, 3, 1)", "min(3, 1 + 100 / m * max(0 m, x - 0.3 m))"}) {
    const AnalysedRun run(
        std::string("unlatch: 1\nname: read\nstep: {dt: 10 ms, until: 1 s}\nbodies: {b: {mass: 2, inertia: [1, 1, 1], "
                    "velocity: [0.7, 0, 0]}}\nquantities:\n  x: {position: {body: b, component: x}}\n  seen: "
                    "{expression: \"") +
        law + "\"}\nrequirements:\n  - {id: seen, quantity: seen, at_most: 9}\n");
    EXPECT_NEAR(run.judge("seen").value, 3, kExact) << law;
  }
}

}  // namespace
}  // namespace unlatch::test::corners_test
