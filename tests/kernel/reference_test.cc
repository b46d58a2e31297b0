// The kernel against independently computed trajectories, by a dense solve and a high-order integrator at tolerance
// 1e-13 (tests/data). The bounds are the required accuracies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"

namespace unlatch::test::reference_test {
namespace {

using nlohmann::json;

constexpr double kEventTime = 1e-6;      // s
constexpr double kPosition = 1e-6;       // m, at 2 s
constexpr double kReaction = 1e-9;       // relative
constexpr double kDrift = 1e-12;         // m, rad
constexpr double kAngle = 1e-6;          // rad
constexpr double kTree3Position = 1e-8;  // m, at 5 s
constexpr double kMomentum = 1e-10;      // relative to the momenta that the bodies carry

struct Happening {
  double time;
  std::string name, subject;
};

// Steps to `until`, calling `at_tick` after every step; checks properties of every step meanwhile.
template <class F>
std::vector<Happening> run(Simulation& simulation, const Model& model, double until, F&& at_tick) {
  std::vector<Happening> log;
  double drift = 0;
  const long ticks = std::lround(until / simulation.plan.get_options().dt);
  for (long i = 0; i < ticks; ++i) {
    const StepReport report = simulation.advance();
    EXPECT_EQ(report.status, StepStatus::kOk) << get_status_text(report.status);
    EXPECT_EQ(report.postponed, 0);
    for (const FiredEvent& fired : report.events) {
      const Event& event = model.events[static_cast<std::size_t>(fired.event)];
      log.push_back({fired.time, event.name, event.subject});
    }
    drift = std::max(drift, calc_drift(simulation.data(), simulation.state, simulation.evaluation()));
    if (report.status != StepStatus::kOk) break;
    at_tick(simulation);
  }
  EXPECT_LT(drift, kDrift);
  return log;
}

double calc_position_error(const State& state, const json& states) {
  double error = 0;
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    const Eigen::Vector3d p = to_vector(states[b]);
    error = std::max({error, std::abs(state.bodies[b].p.x - p.x()), std::abs(state.bodies[b].p.y - p.y()),
                      std::abs(state.bodies[b].p.z - p.z())});
  }
  return error;
}

// Largest error over all the reference's sample times up to `until`, and the last one's.
template <class F>
std::vector<Happening> run_along(Simulation& simulation, const Model& model, const json& trajectory, double until,
                                 double& worst, F&& extra) {
  std::map<long, std::string> samples;
  for (const auto& [time, sample] : trajectory.items())
    samples[std::lround(std::stod(time) / simulation.plan.get_options().dt)] = time;
  return run(simulation, model, until, [&](Simulation& s) {
    const auto sample = samples.find(s.state.header->tick);
    if (sample == samples.end()) return;
    worst = std::max(worst, calc_position_error(s.state, trajectory[sample->second]["states"]));
    extra(s, trajectory[sample->second]);
  });
}

TEST(Reference, BoostersSeparateWhenAndWhereTheyShould) {
  const json reference = load_reference("soyuz_nominal");
  const Model model = build_soyuz(reference);
  Simulation simulation(model);
  double worst = 0;
  const auto log = run_along(simulation, model, reference["trajectory"], 2.0, worst, [](Simulation&, const json&) {});
  EXPECT_LT(worst, kPosition);

  std::map<std::string, double> times;
  for (const Happening& h : log) times[h.name + h.subject] = h.time;
  const std::map<char, std::string> names{{'r', "release"}, {'K', "contact"}, {'l', "liftoff"}};
  double worst_time = 0;
  for (const json& event : reference["events"]) {
    const std::string key = names.at(event[2].get<std::string>()[0]) + "booster" + std::to_string(event[1].get<int>());
    ASSERT_TRUE(times.contains(key)) << key;
    worst_time = std::max(worst_time, std::abs(times[key] - event[0].get<double>()));
  }
  EXPECT_LT(worst_time, kEventTime);
  EXPECT_EQ(log.size(), 16u);  // twelve of the reference, and four nozzles that open
  std::printf("boosters: position error %.2e m, event time error %.2e s\n", worst, worst_time);
}

TEST(Reference, FirstReactionsOfTheBoostersAgree) {
  const json reference = load_reference("soyuz_nominal");
  Simulation simulation(build_soyuz(reference));
  ASSERT_EQ(update_outputs(simulation.plan, {simulation.commands}, simulation.state, simulation.workspace),
            StepStatus::kOk);
  const json& lambda = reference["multipliers"]["0.0"]["lam"];
  const int rows[] = {kX, kY, kZ, kRotX, kRotZ};
  const double scale = std::abs(lambda[0].get<double>());
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t r = 0; r < 5; ++r)
      EXPECT_NEAR(simulation.workspace.multipliers[6 * k + static_cast<std::size_t>(rows[r])],
                  lambda[5 * k + r].get<double>(), kReaction * scale);
}

TEST(Reference, SolarArrayLatchesElastically) {
  const json reference = load_reference("solar_elastic");
  const Model model = build_solar(reference);
  Simulation simulation(model);
  double worst = 0, worst_angle = 0;
  const auto log =
      run_along(simulation, model, reference["trajectory"], 20.0, worst, [&](Simulation& s, const json& sample) {
        for (std::size_t j = 0; j < 2; ++j) {
          const double sign = reference["params"][j == 0 ? "spring1" : "spring2"]["sign"];
          worst_angle = std::max(
              worst_angle,
              std::abs(sign * s.evaluation().coordinates[find_coordinate(s.data(), static_cast<int>(j), kRotZ)] -
                       sample["theta"][j][0].get<double>()));
        }
      });
  ASSERT_EQ(log.size(), 2u);
  EXPECT_EQ(log[0].name, "latch2");
  EXPECT_NEAR(log[0].time, reference["events"][0][0].get<double>(), kEventTime);
  EXPECT_NEAR(log[1].time, reference["events"][1][0].get<double>(), kEventTime);
  EXPECT_LT(worst_angle, kAngle);
  EXPECT_LT(worst, kPosition);
  std::printf("array: angle error %.2e rad, position error %.2e m, latch errors %.2e %.2e s\n", worst_angle, worst,
              log[0].time - reference["events"][0][0].get<double>(),
              log[1].time - reference["events"][1][0].get<double>());
}

TEST(Reference, ThreeBodyTreeFollowsItsTrajectory) {
  const json reference = load_reference("tree3");
  const Model model = build_tree3(reference);
  Simulation simulation(model);
  double worst = 0;
  run_along(simulation, model, reference["trajectory"], 5.0, worst, [](Simulation&, const json&) {});
  EXPECT_LT(worst, kTree3Position);
  std::printf("tree3: position error %.2e m\n", worst);
}

TEST(Reference, TwentyBodyTreeHasTheReferenceAccelerationsAndMultipliers) {
  const json reference = load_reference("tree20");
  Simulation simulation(build_tree20(reference));
  ASSERT_EQ(update_outputs(simulation.plan, {simulation.commands}, simulation.state, simulation.workspace),
            StepStatus::kOk);
  double largest = 0, error = 0, largest_lambda = 0, error_lambda = 0;
  for (std::size_t b = 0; b < 20; ++b) {
    const Spatial a = simulation.workspace.accelerations[b];
    const Vec3 ang = transpose_times(read_kinematics(simulation.evaluation(), static_cast<int>(b)).R, a.ang);
    const double ours[6] = {a.lin.x, a.lin.y, a.lin.z, ang.x, ang.y, ang.z};
    for (std::size_t i = 0; i < 6; ++i) {
      const double theirs = reference["acc"][b][i];
      largest = std::max(largest, std::abs(theirs));
      error = std::max(error, std::abs(theirs - ours[i]));
    }
  }
  std::size_t next = 0;
  for (std::size_t j = 0; j < simulation.data().joints.size(); ++j)
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(get_active_rows(simulation.data(), simulation.state, static_cast<int>(j)), r)) continue;
      const double theirs = reference["lam"][next++];
      largest_lambda = std::max(largest_lambda, std::abs(theirs));
      error_lambda = std::max(error_lambda,
                              std::abs(theirs - simulation.workspace.multipliers[6 * j + static_cast<std::size_t>(r)]));
    }
  EXPECT_EQ(next, reference["lam"].size());
  EXPECT_LT(error / largest, kReaction);
  EXPECT_LT(error_lambda / largest_lambda, kReaction);
  std::printf("tree20: accelerations %.2e, multipliers %.2e relative\n", error / largest,
              error_lambda / largest_lambda);
}

TEST(Reference, MomentumIsTheSameBeforeAndAfterEveryEvent) {
  const json reference = load_reference("soyuz_nominal");
  const Model model = build_soyuz(reference);
  Simulation simulation(model);
  int audits = 0;
  for (int i = 0; i < 1000; ++i) {
    const StepReport report = simulation.advance();
    for (const EventAudit& audit : report.audits) {
      ++audits;
      const double scale = norm(audit.before.momentum);
      EXPECT_LT(norm(audit.jump.momentum), kMomentum * scale);
      EXPECT_EQ(audit.allowed.kinetic, 0);
      EXPECT_LT(std::abs(audit.jump.kinetic), kMomentum * audit.before.kinetic);
    }
  }
  EXPECT_GE(audits, 4);
}

}  // namespace
}  // namespace unlatch::test::reference_test
