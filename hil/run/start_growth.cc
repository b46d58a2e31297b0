#include "hil/run/start_growth.h"

#include <algorithm>

#include "hil/run/run.h"
#include "hil/scenario/model/index.h"

namespace unlatch::hil {
namespace {

constexpr double kChange = 5e-7;  // m, m/s; below the gaps that joints may have at the start
constexpr double kBlocked = 0.1;  // part of the change that is left after the first step, unless joints hold it

// Places and velocities of all bodies after the first step, and places at the end.
struct Course {
  std::vector<Vec3> places, velocities, end;
};

// Nothing if the run fails, or the changed model is not possible.
std::optional<Course> fly(const Scenario& scenario, std::int64_t last, const std::atomic<bool>& interrupted) {
  Course course;
  try {
    const auto simulation = build_simulation(scenario);
    const auto list = [&](std::vector<Vec3>& into, auto BodyState::*member) {
      for (std::size_t b = 0; b < scenario.model.bodies.size(); ++b)
        into.push_back(simulation->state().bodies[b].*member);
    };
    while (simulation->get_tick() < last) {
      if (interrupted || simulation->step().status != StepStatus::kOk) return std::nullopt;
      if (!course.places.empty()) continue;
      list(course.places, &BodyState::p);
      list(course.velocities, &BodyState::v);
    }
    list(course.end, &BodyState::p);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return course;
}

// The largest distance, and whose it is.
std::pair<double, std::size_t> find_largest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  std::pair<double, std::size_t> largest{0, 0};
  for (std::size_t i = 0; i < a.size(); ++i)
    if (const double distance = norm(a[i] - b[i]); distance > largest.first) largest = {distance, i};
  return largest;
}

}  // namespace

std::optional<std::vector<StartGrowth>> measure_growth(const Scenario& scenario, std::int64_t last,
                                                       const std::atomic<bool>& interrupted) {
  const std::vector<Body>& bodies = scenario.model.bodies;
  const auto movable = std::ranges::count_if(bodies, [](const Body& body) { return !body.marker; });
  if (static_cast<std::size_t>(movable) > kMostGrowthBodies) return std::nullopt;
  const std::optional<Course> nominal = fly(scenario, last, interrupted);
  if (!nominal) return std::nullopt;
  const double length = static_cast<double>(last) * scenario.dt;
  std::vector<StartGrowth> found;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].marker) continue;
    for (const bool velocity : {false, true}) {
      StartGrowth worst{.start = bodies[b].name, .end = {}, .velocity = velocity};
      for (int axis = 0; axis < 3; ++axis) {
        Scenario changed = scenario;
        Body& body = changed.model.bodies[b];
        (velocity ? body.v_WB : body.p_WB)[axis] += kChange;
        const std::optional<Course> course = fly(changed, last, interrupted);
        if (interrupted) return std::nullopt;
        if (!course) continue;
        const double start = velocity ? find_largest(course->velocities, nominal->velocities).first
                                      : find_largest(course->places, nominal->places).first;
        if (start < kBlocked * kChange) continue;
        const auto [distance, whose] = find_largest(course->end, nominal->end);
        const double factor = distance / (velocity ? start * length : start);
        if (factor > worst.factor) worst.factor = factor, worst.end = bodies[whose].name;
      }
      if (worst.factor >= kNotableGrowth) found.push_back(worst);
    }
  }
  std::ranges::stable_sort(found, [](const StartGrowth& a, const StartGrowth& b) { return a.factor > b.factor; });
  return found;
}

}  // namespace unlatch::hil
