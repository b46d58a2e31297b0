#include "hil/run/start_growth.h"

#include <algorithm>

#include "hil/run/run.h"
#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

using Of = StartGrowth::Of;

constexpr double kChange = 5e-7;  // m, m/s, rad, rad/s; below the gaps that joints may have at the start
constexpr double kBlocked = 0.1;  // part of the change that is left after the first step, unless joints hold it

// All bodies at tick `last`; nothing if the run fails, or the changed model is not possible.
std::optional<std::vector<BodyState>> fly(const Scenario& scenario, std::int64_t last,
                                          const std::atomic<bool>& interrupted) {
  try {
    const auto simulation = build_simulation(scenario);
    while (simulation->get_tick() < last)
      if (interrupted || simulation->step().status != StepStatus::kOk) return std::nullopt;
    return std::vector<BodyState>(simulation->state().bodies.begin(), simulation->state().bodies.end());
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// Angle between two attitudes, rad, for small ones.
double calc_turn(const Quat& a, const Quat& b) {
  const Quat turn = conjugate(a) * b;
  return 2 * norm(Vec3{turn.x, turn.y, turn.z});
}

// Difference of one body between two courses: m, m/s, rad or rad/s.
double calc_difference(Of of, const BodyState& a, const BodyState& b) {
  switch (of) {
    case Of::kPlace:
      return norm(a.p - b.p);
    case Of::kVelocity:
      return norm(a.v - b.v);
    case Of::kAttitude:
      return calc_turn(a.q, b.q);
    case Of::kRate:
      return norm(a.w - b.w);
  }
  return 0;
}

// The largest difference, and whose it is.
std::pair<double, std::size_t> find_largest(Of of, const std::vector<BodyState>& a, const std::vector<BodyState>& b) {
  std::pair<double, std::size_t> largest{0, 0};
  for (std::size_t i = 0; i < a.size(); ++i)
    if (const double difference = calc_difference(of, a[i], b[i]); difference > largest.first)
      largest = {difference, i};
  return largest;
}

void change(Of of, int axis, Body& body) {
  switch (of) {
    case Of::kPlace:
      body.p_WB[axis] += kChange;
      break;
    case Of::kVelocity:
      body.v_WB[axis] += kChange;
      break;
    case Of::kAttitude:
      body.q_WB =
          Eigen::Quaterniond(body.q_WB) * Eigen::Quaterniond(Eigen::AngleAxisd(kChange, Eigen::Vector3d::Unit(axis)));
      break;
    case Of::kRate:
      body.w_WB_B[axis] += kChange;
      break;
  }
}

}  // namespace

const char* get_name(StartGrowth::Of of) {
  switch (of) {
    case Of::kPlace:
      return "place";
    case Of::kVelocity:
      return "velocity";
    case Of::kAttitude:
      return "attitude";
    case Of::kRate:
      return "rate";
  }
  return "";
}

bool ends_alike(const Scenario& other, std::int64_t last, const Simulation& simulation,
                const std::atomic<bool>& interrupted) {
  constexpr double kAlike = 1e-4;
  const auto end = fly(other, last, interrupted);
  if (!end) return false;
  const std::span<const BodyState> reached = simulation.state().bodies;
  double way = 0;
  for (std::size_t b = 0; b < reached.size(); ++b) {
    const Eigen::Vector3d& start = other.model.bodies[b].p_WB;
    way = std::max(way, norm(reached[b].p - Vec3{start.x(), start.y(), start.z()}));
  }
  for (std::size_t b = 0; b < reached.size(); ++b)
    if (!(calc_difference(Of::kPlace, (*end)[b], reached[b]) <= kAlike * way &&
          calc_difference(Of::kAttitude, (*end)[b], reached[b]) <= kAlike))
      return false;
  return true;
}

std::optional<std::vector<StartGrowth>> measure_growth(const Scenario& scenario, const Scenario& flown,
                                                       std::int64_t last, const std::atomic<bool>& interrupted) {
  const std::vector<Body>& bodies = scenario.model.bodies;
  const auto movable = std::ranges::count_if(bodies, [](const Body& body) { return !body.marker; });
  if (static_cast<std::size_t>(movable) > kMostGrowthBodies) return std::nullopt;
  const auto nominal_begin = fly(scenario, 1, interrupted), nominal_end = fly(flown, last, interrupted);
  if (!nominal_begin || !nominal_end) return std::nullopt;
  const double length = static_cast<double>(last) * flown.dt;
  std::vector<StartGrowth> found;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].marker) continue;
    for (const Of of : {Of::kPlace, Of::kVelocity, Of::kAttitude, Of::kRate}) {
      const bool over_time = of == Of::kVelocity || of == Of::kRate;
      const Of at_end = of == Of::kPlace || of == Of::kVelocity ? Of::kPlace : Of::kAttitude;
      StartGrowth worst{.start = bodies[b].name, .end = {}, .of = of};
      for (int axis = 0; axis < 3; ++axis) {
        const auto fly_changed = [&](Scenario changed, std::int64_t until) {
          change(of, axis, changed.model.bodies[b]);
          return fly(changed, until, interrupted);
        };
        const auto begin = fly_changed(scenario, 1);
        const double start = begin ? find_largest(of, *begin, *nominal_begin).first : 0;
        if (start < kBlocked * kChange) continue;
        const auto end = fly_changed(flown, last);
        if (interrupted) return std::nullopt;
        if (!end) continue;
        const auto [difference, whose] = find_largest(at_end, *end, *nominal_end);
        const double factor = difference / (over_time ? start * length : start);
        if (factor > worst.factor) worst.factor = factor, worst.end = bodies[whose].name;
      }
      if (worst.factor >= kNotableGrowth) found.push_back(worst);
    }
  }
  std::ranges::stable_sort(found, [](const StartGrowth& a, const StartGrowth& b) { return a.factor > b.factor; });
  return found;
}

}  // namespace unlatch::hil
