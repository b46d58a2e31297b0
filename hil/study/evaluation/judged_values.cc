#include "hil/study/evaluation/judged_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/run/analysis/accuracy.h"

namespace unlatch::hil {
namespace {

using Kind = ResultColumn::Kind;

constexpr double kStill = 1e-6;  // of the SI unit: the smallest scale

double get_finite_size(double limit) { return std::isfinite(limit) ? std::abs(limit) : 0; }

// The name without the letter of a component: "core.v" of core.vx.
std::string get_vector_name(const std::string& name) {
  return !name.empty() && std::string("wxyz").find(name.back()) != std::string::npos ? name.substr(0, name.size() - 1)
                                                                                     : name;
}

bool is_time(const ResultColumn& column) { return column.kind == Kind::kEvent || column.unit == "s"; }

}  // namespace

JudgedValues::JudgedValues(const SampleEvaluator& evaluator, const std::vector<std::size_t>& also)
    : evaluator_(evaluator) {
  const std::vector<ResultColumn>& columns = evaluator.columns();
  std::vector<bool> judged(columns.size());
  for (const std::size_t column : also) judged[column] = true;
  for (std::size_t i = 0; i < columns.size(); ++i)
    judged[i] = judged[i] || columns[i].kind == Kind::kRequirement || columns[i].kind == Kind::kOutput ||
                columns[i].kind == Kind::kCurve;
  if (std::ranges::find(judged, true) == judged.end())
    for (std::size_t i = 0; i < columns.size(); ++i) judged[i] = columns[i].kind != Kind::kClearanceTime;
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (judged[i] && columns[i].kind != Kind::kStep && columns[i].kind != Kind::kStepError &&
        columns[i].kind != Kind::kWithoutBlow && columns[i].kind != Kind::kUncertainty)
      add(i);
}

std::size_t JudgedValues::add_group(const std::string& key, double least) {
  const auto known = std::ranges::find(keys_, key);
  if (known != keys_.end()) return static_cast<std::size_t>(known - keys_.begin());
  keys_.push_back(key);
  groups_.push_back({std::max(least, kStill)});
  return groups_.size() - 1;
}

void JudgedValues::add(std::size_t number) {
  const ResultColumn& column = evaluator_.columns()[number];
  const Scenario& scenario = evaluator_.tree().get_nominal();
  std::string key = column.name;
  double least = 0;
  switch (column.kind) {
    case Kind::kRequirement:
    case Kind::kMargin: {
      const Requirement& requirement = scenario.requirements[column.index];
      least = std::max(get_finite_size(requirement.least), get_finite_size(requirement.most));
      break;
    }
    case Kind::kSeparation:
      if (column.part < 2) key = "velocity of separation." + std::to_string(column.index);
      break;
    case Kind::kPeak:
      key = (column.part < kRotX ? "force." : "moment.") + std::to_string(column.index);
      break;
    case Kind::kOutput:
      key = get_vector_name(evaluator_.chosen().values[column.index].name);
      break;
    case Kind::kCurve: {
      const std::size_t point = column.name.rfind('@');
      key = get_vector_name(column.name.substr(0, point));
      break;
    }
    default:
      break;
  }
  if (column.kind != Kind::kRequirement && column.kind != Kind::kMargin && is_time(column)) {
    key = "time";
    least = scenario.until;
  }
  values_.push_back({number, add_group(key, least)});
}

JudgedValues::Difference JudgedValues::compare(const SampleResult& coarse, const SampleResult& fine) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (coarse.status != SampleStatus::kDone || fine.status != SampleStatus::kDone) {
    if (coarse.status == SampleStatus::kFaulted && fine.status == SampleStatus::kFaulted) return {};
    const SampleResult& worse = coarse.status != SampleStatus::kDone ? coarse : fine;
    return {kInfinite, kSampleStatusNames[static_cast<std::size_t>(worse.status)] + ": " + worse.message};
  }
  std::vector<double> scales;
  for (const Group& group : groups_) scales.push_back(group.least);
  for (const Value& value : values_)
    for (const SampleResult* result : {&coarse, &fine})
      if (const double size = std::abs(result->values[value.column]); size > scales[value.group])
        scales[value.group] = size;
  for (std::size_t group = 0; group < keys_.size(); ++group) {  // a moment: also its joint's forces times their arm
    if (!keys_[group].starts_with("moment.")) continue;
    const std::string joint = keys_[group].substr(std::string("moment.").size());
    const auto force = std::ranges::find(keys_, "force." + joint);
    if (force == keys_.end()) continue;
    const double arm = calc_arm(evaluator_.tree().get_nominal().model.joints[std::stoul(joint)]);
    scales[group] = std::max(scales[group], scales[static_cast<std::size_t>(force - keys_.begin())] * arm);
  }
  Difference largest;
  for (const Value& value : values_) {
    const double a = coarse.values[value.column], b = fine.values[value.column];
    if (a == b || (std::isnan(a) && std::isnan(b))) continue;
    const double size = std::isnan(a) || std::isnan(b) ? kInfinite : std::abs(a - b) / scales[value.group];
    if (size > largest.size) largest = {size, evaluator_.columns()[value.column].name};
  }
  return largest;
}

}  // namespace unlatch::hil
