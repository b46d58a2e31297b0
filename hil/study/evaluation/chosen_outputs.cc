#include "hil/study/evaluation/chosen_outputs.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "hil/run/analysis/run_analysis.h"

namespace unlatch::hil {
namespace {

using Take = ChosenOutput::Take;

constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();

std::string describe_time(double time) {
  constexpr int kDigits = 9;  // 0.15, not 0.15000000000000002
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, time, std::chars_format::general, kDigits).ptr};
}

void sort_out(std::vector<std::size_t>& outputs) {
  std::ranges::sort(outputs);
  outputs.erase(std::unique(outputs.begin(), outputs.end()), outputs.end());
}

}  // namespace

const std::vector<std::string> kTakeNames{"final", "min", "max"};

std::size_t ChosenOutputs::count() const {
  std::size_t sum = count_steps() + values.size();
  for (const ChosenCurves& group : curves) sum += group.curves.size() * group.points;
  return sum;
}

std::vector<ResultColumn> list_columns(const ChosenOutputs& chosen) {
  std::vector<ResultColumn> columns;
  columns.reserve(chosen.count());
  if (chosen.steps) {
    columns.push_back({ResultColumn::Kind::kStep, "step", "s", 0, 0});
    columns.push_back({ResultColumn::Kind::kStepError, "step.error", "", 0, 0});
  }
  for (std::size_t i = 0; i < chosen.values.size(); ++i) {
    const ChosenOutput& value = chosen.values[i];
    columns.push_back({ResultColumn::Kind::kOutput,
                       "output." + value.name + "." + kTakeNames[static_cast<std::size_t>(value.take)], value.unit, i,
                       0});
  }
  std::size_t number = 0;
  for (const ChosenCurves& group : chosen.curves)
    for (const ChosenCurves::Curve& curve : group.curves) {
      for (std::size_t point = 0; point < group.points; ++point)
        columns.push_back({ResultColumn::Kind::kCurve,
                           "curve." + curve.name + "@" + describe_time(group.get_time(point)), curve.unit, number,
                           point});
      ++number;
    }
  return columns;
}

std::vector<ResultColumn> list_columns(const Scenario& scenario, const ChosenOutputs& chosen) {
  std::vector<ResultColumn> columns = list_columns(scenario);
  for (ResultColumn& column : list_columns(chosen)) columns.push_back(std::move(column));
  return columns;
}

OutputTracker::OutputTracker(const ChosenOutputs& chosen, const Scenario& scenario, const Simulation& simulation)
    : chosen_(chosen),
      simulation_(simulation),
      dt_(scenario.dt),
      reader_(scenario, simulation),
      scratch_(reader_.count_values()),
      values_(chosen.values.size(), kUnseen) {
  for (const ChosenOutput& value : chosen.values)
    places_.push_back(find(value.name, value.take == Take::kFinal ? at_the_end_ : at_every_tick_));
  for (const ChosenCurves& group : chosen.curves) {
    Series& series = series_.emplace_back();
    for (const ChosenCurves::Curve& curve : group.curves) series.places.push_back(find(curve.name, series.outputs));
    series.values.assign(group.curves.size() * group.points, kUnseen);
    sort_out(series.outputs);
  }
  sort_out(at_every_tick_);
  sort_out(at_the_end_);
}

// Place of a value, and its output among those to read.
std::optional<std::size_t> OutputTracker::find(const std::string& name, std::vector<std::size_t>& outputs) const {
  for (std::size_t i = 0; i < reader_.list().size(); ++i) {
    const Output& output = reader_.list()[i];
    for (std::size_t k = 0; k < output.columns.size(); ++k) {
      if (output.columns[k].name != name) continue;
      outputs.push_back(i);
      return output.first + k;
    }
  }
  return std::nullopt;
}

std::vector<int> OutputTracker::list_sensors() const {
  std::vector<int> sensors;
  const auto add = [&](const std::vector<std::size_t>& outputs) {
    for (const std::size_t i : outputs) {
      const Output& output = reader_.list()[i];
      if (output.kind == Output::Kind::kSensor || output.kind == Output::Kind::kReceived)
        sensors.push_back(output.subject);
    }
  };
  add(at_every_tick_);
  add(at_the_end_);
  for (const Series& series : series_) add(series.outputs);
  return sensors;
}

void OutputTracker::look() {
  const std::int64_t tick = simulation_.get_tick();
  if (!at_every_tick_.empty()) {
    reader_.read(at_every_tick_, scratch_);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const Take take = chosen_.values[i].take;
      if (take == Take::kFinal || !places_[i]) continue;
      const double value = scratch_[*places_[i]];
      double& best = values_[i];
      if (std::isnan(best) || (take == Take::kMin ? value < best : value > best)) best = value;
    }
  }
  for (std::size_t i = 0; i < series_.size(); ++i) {
    Series& series = series_[i];
    const ChosenCurves& group = chosen_.curves[i];
    for (; series.next < group.points && calc_nearest_tick(group.get_time(series.next), dt_) <= tick; ++series.next) {
      if (calc_nearest_tick(group.get_time(series.next), dt_) != tick) continue;
      reader_.read(series.outputs, scratch_);
      for (std::size_t k = 0; k < series.places.size(); ++k)
        if (series.places[k]) series.values[k * group.points + series.next] = scratch_[*series.places[k]];
    }
  }
}

std::vector<double> OutputTracker::finish(bool reached_end) {
  if (reached_end && !at_the_end_.empty()) {
    reader_.read(at_the_end_, scratch_);
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (chosen_.values[i].take == Take::kFinal && places_[i]) values_[i] = scratch_[*places_[i]];
  }
  std::vector<double> all = values_;
  all.reserve(chosen_.count());
  for (const Series& series : series_) all.insert(all.end(), series.values.begin(), series.values.end());
  return all;
}

}  // namespace unlatch::hil
