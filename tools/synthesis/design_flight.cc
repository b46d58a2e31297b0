#include "tools/synthesis/design_flight.h"

#include <algorithm>
#include <cmath>

#include "hil/run/run.h"

namespace unlatch::tools {
namespace {

constexpr std::int64_t kIntervals = 400;  // of a curve

// Keeps the least and the greatest value of each interval, in the order in which they came.
class CurveKeeper {
 public:
  void add(std::int64_t interval, double time, double value) {
    if (interval != interval_ || std::isnan(value) != std::isnan(low_.value)) flush();
    interval_ = interval;
    if (!any_ || value < low_.value) low_ = {time, value};
    if (!any_ || value > high_.value) high_ = {time, value};
    any_ = true;
  }
  DesignCurve take() {
    flush();
    const bool has_values =
        std::any_of(curve_.values.begin(), curve_.values.end(), [](double value) { return !std::isnan(value); });
    return has_values ? std::move(curve_) : DesignCurve{};
  }

 private:
  struct Point {
    double time = 0, value = 0;
  };
  void flush() {
    if (any_) {
      const bool rises = low_.time <= high_.time;
      put(rises ? low_ : high_);
      if (low_.time != high_.time) put(rises ? high_ : low_);
    }
    any_ = false;
  }
  void put(const Point& point) {
    curve_.times.push_back(point.time);
    curve_.values.push_back(point.value);
  }

  DesignCurve curve_;
  std::int64_t interval_ = 0;
  Point low_, high_;
  bool any_ = false;
};

}  // namespace

std::optional<std::size_t> find_requirement(const hil::Scenario& scenario, const std::string& id) {
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i)
    if (scenario.requirements[i].id == id) return i;
  return std::nullopt;
}

std::vector<DesignCurve> fly_design(const hil::DesignProblem& problem, const hil::DesignPoint& point,
                                    const std::atomic<bool>& stop) {
  std::vector<DesignCurve> curves(problem.constraints.size());
  std::unique_ptr<hil::Simulation> simulation;
  hil::Scenario scenario;
  try {
    scenario = problem.tree->read(hil::make_settings(problem, point));
    simulation = hil::build_simulation(scenario);
  } catch (const hil::ScenarioError&) {
    return curves;
  }
  std::vector<std::optional<std::size_t>> requirements;
  for (const hil::DesignConstraint& constraint : problem.constraints)
    requirements.push_back(find_requirement(scenario, constraint.id));
  std::vector<CurveKeeper> keepers(curves.size());
  hil::RunAnalysis analysis(scenario, *simulation);
  const std::int64_t last = hil::calc_nearest_tick(scenario.until, scenario.dt);
  std::int64_t tick = 0;
  hil::run_fast(*simulation, analysis, nullptr, last, stop, [&] {
    for (std::size_t i = 0; i < curves.size(); ++i)
      if (requirements[i])
        keepers[i].add(tick * kIntervals / (last + 1), static_cast<double>(tick) * scenario.dt,
                       analysis.get_requirement_now(*requirements[i]));
    ++tick;
  });
  if (stop) return curves;
  for (std::size_t i = 0; i < curves.size(); ++i) curves[i] = keepers[i].take();
  return curves;
}

}  // namespace unlatch::tools
