#include "tools/optimize/point_flight.h"

#include <algorithm>
#include <cmath>

#include "hil/run/outputs/output_reader.h"
#include "hil/run/run.h"

namespace unlatch::tools {
namespace {

constexpr std::int64_t kIntervals = 400;  // of a curve
constexpr std::size_t kMostColumns = 12;  // of outputs

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
  OptimizeCurve take() {
    flush();
    const bool has_values =
        std::any_of(curve_.values.begin(), curve_.values.end(), [](double value) { return !std::isnan(value); });
    return has_values ? std::move(curve_) : OptimizeCurve{};
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

  OptimizeCurve curve_;
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

namespace {

// A quantity over time: a requirement's, by its id, or a column of the outputs, by its name.
struct Watched {
  std::string name, unit;
  bool is_requirement = true;
};

bool has_curve(const hil::Scenario& scenario, const std::string& id) {
  const auto at = find_requirement(scenario, id);
  return at && !scenario.requirements[*at].is_of_events();
}

std::vector<Watched> list_columns(const hil::Scenario& scenario, hil::Output::Kind kind) {
  std::vector<Watched> list;
  for (const hil::Output& output : hil::list_outputs(scenario))
    for (const hil::Output::Column& column : output.columns)
      if (output.kind == kind && list.size() < kMostColumns) list.push_back({column.name, column.unit, false});
  return list;
}

std::vector<Watched> list_watched(const hil::OptimizeProblem& problem) {
  const hil::Scenario& scenario = problem.tree->get_nominal();
  std::vector<Watched> list;
  for (const hil::OptimizeConstraint& constraint : problem.constraints)
    list.push_back({constraint.id, constraint.unit});
  if (std::ranges::any_of(list, [&](const Watched& one) { return has_curve(scenario, one.name); })) return list;
  std::vector<Watched> others;
  for (const hil::Requirement& requirement : scenario.requirements)
    if (!requirement.is_of_events()) others.push_back({requirement.id, requirement.unit});
  if (others.empty()) others = list_columns(scenario, hil::Output::Kind::kClearance);
  if (others.empty()) others = list_columns(scenario, hil::Output::Kind::kVelocity);
  list.insert(list.end(), others.begin(), others.end());
  return list;
}

// Reads watched quantities at the present state of a run; NaN for those that this scenario does not have.
class WatchedReader {
 public:
  WatchedReader(const std::vector<Watched>& watched, const hil::Scenario& scenario, const hil::Simulation& simulation)
      : reader_(scenario, simulation), scratch_(reader_.count_values()) {
    for (const Watched& one : watched) {
      places_.emplace_back();
      if (one.is_requirement) places_.back().requirement = find_requirement(scenario, one.name);
      for (std::size_t i = 0; i < reader_.list().size() && !one.is_requirement; ++i)
        for (std::size_t k = 0; k < reader_.list()[i].columns.size(); ++k)
          if (reader_.list()[i].columns[k].name == one.name) {
            places_.back().value = reader_.list()[i].first + k;
            outputs_.push_back(i);
          }
    }
  }

  void update() {
    if (!outputs_.empty()) reader_.read(outputs_, scratch_);
  }
  [[nodiscard]] double get(std::size_t i, const hil::RunAnalysis& analysis) const {
    if (places_[i].requirement) return analysis.get_requirement_now(*places_[i].requirement);
    return places_[i].value ? scratch_[*places_[i].value] : std::nan("");
  }

 private:
  struct Place {
    std::optional<std::size_t> requirement, value;
  };
  hil::OutputReader reader_;
  std::vector<double> scratch_;  // values of all outputs
  std::vector<Place> places_;
  std::vector<std::size_t> outputs_;
};

}  // namespace

std::vector<OptimizeCurve> fly_point(const hil::OptimizeProblem& problem, const hil::OptimizePoint& point,
                                     const std::atomic<bool>& stop) {
  const std::vector<Watched> watched = list_watched(problem);
  std::vector<OptimizeCurve> curves(watched.size());
  std::unique_ptr<hil::Simulation> simulation;
  hil::Scenario scenario;
  try {
    scenario = problem.tree->read(hil::make_settings(problem, point));
    simulation = hil::build_simulation(scenario);
  } catch (const hil::ScenarioError&) {
    return curves;
  }
  std::vector<CurveKeeper> keepers(curves.size());
  hil::RunAnalysis analysis(scenario, *simulation);
  WatchedReader reader(watched, scenario, *simulation);
  const std::int64_t last = hil::calc_nearest_tick(scenario.until, scenario.dt);
  std::int64_t tick = 0;
  hil::run_fast(*simulation, analysis, nullptr, last, stop, [&] {
    reader.update();
    for (std::size_t i = 0; i < curves.size(); ++i)
      keepers[i].add(tick * kIntervals / (last + 1), static_cast<double>(tick) * scenario.dt, reader.get(i, analysis));
    ++tick;
  });
  if (stop) return curves;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    curves[i] = keepers[i].take();
    curves[i].name = watched[i].name;
    curves[i].unit = watched[i].unit;
  }
  return curves;
}

}  // namespace unlatch::tools
