#include "hil/study/evaluation/results.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>

#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

using Kind = ResultColumn::Kind;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool can_be_free(const Joint& joint) {
  return std::any_of(joint.modes.begin(), joint.modes.end(), [](const JointMode& mode) { return mode.rows == 0; });
}

std::string name_pair(const ClearancePair& pair) { return "clearance." + pair.a.name + "." + pair.b.name; }

// Lists events without repeated pairs of name and subject: the first one counts.
std::vector<std::size_t> list_distinct_events(const Model& model) {
  std::vector<std::size_t> distinct;
  for (std::size_t i = 0; i < model.events.size(); ++i) {
    const auto same = [&](std::size_t other) {
      return get_event_name(model.events[other]) == get_event_name(model.events[i]);
    };
    if (std::none_of(distinct.begin(), distinct.end(), same)) distinct.push_back(i);
  }
  return distinct;
}

double get_separation(const Separation& separation, std::size_t part) {
  if (part == 0) return separation.along;
  return part == 1 ? separation.across : separation.relative.transverse;
}

struct ContactValue {
  const char *name, *unit;
  double (*get)(const ContactRecord&);
};
constexpr ContactValue kContactValues[] = {
    {"touch", "s", [](const ContactRecord& contact) { return contact.touch.value_or(kNone); }},
    {"peak", "N", [](const ContactRecord& contact) { return contact.peak_force; }},
    {"depth", "m", [](const ContactRecord& contact) { return contact.depth; }},
    {"impulse", "N s", [](const ContactRecord& contact) { return contact.totals.impulse; }},
    {"dissipated", "J", [](const ContactRecord& contact) { return contact.totals.dissipated; }},
    {"duration", "s", [](const ContactRecord& contact) { return contact.duration; }},
};

// Parts of a run's analysis by the names of the columns.
struct Results {
  Results(const Scenario& scenario_in, const RunAnalysis& analysis_in)
      : scenario(scenario_in),
        analysis(analysis_in),
        verdicts(analysis_in.judge()),
        separations(analysis_in.list_separations()),
        contacts(analysis_in.list_contacts()) {
    for (const TimelineEntry& entry : analysis.timeline)
      events.emplace(entry.subject.empty() ? entry.name : entry.name + ":" + entry.subject, entry.time);
  }

  [[nodiscard]] double get(const ResultColumn& column) const {
    switch (column.kind) {
      case Kind::kRequirement:
      case Kind::kMargin:
        for (const Verdict& verdict : verdicts)
          if (verdict.requirement == column.index && verdict.evaluated)
            return column.kind == Kind::kMargin ? verdict.margin : verdict.value;
        return kNone;
      case Kind::kWithoutBlow:
        for (const Verdict& verdict : verdicts)
          if (verdict.requirement == column.index && verdict.leaves_out_blow()) return verdict.blow;
        return kNone;
      case Kind::kUncertainty:
        for (const Verdict& verdict : verdicts)
          if (verdict.requirement == column.index && verdict.is_uncertain() && verdict.is_error_known())
            return verdict.uncertainty;
        return kNone;
      case Kind::kEvent: {
        const auto found = events.find(get_event_name(scenario.model.events[column.index]));
        return found == events.end() ? kNone : found->second;
      }
      case Kind::kClearance:
        return analysis.clearances()[column.index].smallest;
      case Kind::kClearanceTime:
        return analysis.clearances()[column.index].time;
      case Kind::kReleased: {
        const auto& released = analysis.clearances()[column.index].after_release;
        return released ? released->smallest : kNone;
      }
      case Kind::kTipOff:
        for (const TipOff& tip_off : analysis.tip_offs)
          if (tip_off.joint == scenario.model.joints[column.index].name) return norm(tip_off.w);
        return kNone;
      case Kind::kSeparation:
        for (const Separation& separation : separations)
          if (separation.joint == scenario.model.joints[column.index].name)
            return get_separation(separation, column.part);
        return kNone;
      case Kind::kPeak:
        return analysis.get_peak(column.index, column.part).value;
      case Kind::kContact:
        return kContactValues[column.part].get(contacts[column.index]);
      case Kind::kOutput:
      case Kind::kCurve:
      case Kind::kStep:
      case Kind::kStepError:
        break;  // of the evaluator and its OutputTracker
    }
    return kNone;
  }

  const Scenario& scenario;
  const RunAnalysis& analysis;
  const std::vector<Verdict> verdicts;
  const std::vector<Separation> separations;
  const std::vector<ContactRecord> contacts;
  std::map<std::string, double> events;  // first times
};

}  // namespace

std::string describe_unresolved(const Scenario& scenario, const RunAnalysis& analysis) {
  std::string text = analysis.accuracy().describe_unresolved();
  if (!text.empty()) return text;
  for (const Verdict& verdict : analysis.judge())
    if (!verdict.is_resolved())
      return "requirement " + scenario.requirements[verdict.requirement].id + ": " + verdict.unresolved;
  return text;
}

std::string get_event_name(const Event& event) {
  return event.subject.empty() ? event.name : event.name + ":" + event.subject;
}

std::vector<ResultColumn> list_columns(const Scenario& scenario) {
  std::vector<ResultColumn> columns;
  const Model& model = scenario.model;
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i) {
    const Requirement& requirement = scenario.requirements[i];
    columns.push_back({Kind::kRequirement, requirement.id, requirement.unit, i, 0});
    columns.push_back({Kind::kMargin, requirement.id + ".margin", requirement.unit, i, 0});
  }
  for (const std::size_t i : list_distinct_events(model))
    columns.push_back({Kind::kEvent, "event." + get_event_name(model.events[i]), "s", i, 0});
  for (std::size_t i = 0; i < scenario.clearance.size(); ++i) {
    const std::string name = name_pair(scenario.clearance[i]);
    columns.push_back({Kind::kClearance, name, "m", i, 0});
    columns.push_back({Kind::kClearanceTime, name + ".t", "s", i, 0});
    columns.push_back({Kind::kReleased, name + ".released", "m", i, 0});
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    if (!can_be_free(model.joints[i])) continue;
    const std::string& joint = model.joints[i].name;
    columns.push_back({Kind::kTipOff, "tip_off." + joint, "rad/s", i, 0});
    columns.push_back({Kind::kSeparation, "separation." + joint + ".along", "m/s", i, 0});
    columns.push_back({Kind::kSeparation, "separation." + joint + ".across", "m/s", i, 1});
    columns.push_back({Kind::kSeparation, "separation." + joint + ".rate", "rad/s", i, 2});
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const RowSet rows = list_held_rows(model.joints[i]);
    for (int row = 0; row < kRows; ++row)
      if (has_row(rows, row))
        columns.push_back({Kind::kPeak, "peak." + model.joints[i].name + "." + kRowNames[row], row < 3 ? "N" : "N m", i,
                           static_cast<std::size_t>(row)});
  }
  for (std::size_t i = 0; i < model.contacts.size(); ++i)
    for (std::size_t part = 0; part < std::size(kContactValues); ++part)
      columns.push_back({Kind::kContact, "contact." + model.contacts[i].name + "." + kContactValues[part].name,
                         kContactValues[part].unit, i, part});
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i)
    if (scenario.requirements[i].quantity == Requirement::Measure::kReaction)
      columns.push_back({Kind::kWithoutBlow, scenario.requirements[i].id + ".without_blow", "s", i, 0});
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i)
    if (is_bounded(scenario.model, scenario.requirements[i]))
      columns.push_back(
          {Kind::kUncertainty, scenario.requirements[i].id + ".uncertainty", scenario.requirements[i].unit, i, 0});
  return columns;
}

AnalysisRequest list_needs(const std::vector<ResultColumn>& columns) {
  const bool has_peaks = std::any_of(columns.begin(), columns.end(),
                                     [](const ResultColumn& column) { return column.kind == Kind::kPeak; });
  return {.accuracy = false, .reactions = has_peaks, .redundancy = false, .pushes = false, .touches = false};
}

std::vector<double> collect_results(const std::vector<ResultColumn>& columns, const Scenario& scenario,
                                    const RunAnalysis& analysis) {
  const Results results(scenario, analysis);
  std::vector<double> values;
  values.reserve(columns.size());
  for (const ResultColumn& column : columns) values.push_back(results.get(column));
  return values;
}

}  // namespace unlatch::hil
