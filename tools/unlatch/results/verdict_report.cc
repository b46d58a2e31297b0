#include "tools/unlatch/results/verdict_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "hil/scenario/text/xml_text.h"
#include "hil/session/messages/event_names.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/requirements/requirement_list.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

const hil::Requirement& get(const RunReport& report, const hil::Verdict& verdict) {
  return report.scenario.requirements[verdict.requirement];
}

// A far limit says nothing about the rounding of a value: no more than 1e-9 of a unit is taken for that.
constexpr double kFar = 1e3;

// "0.29 ± 0.001 m at 1.3 s, at least 0.1 m, margin 0.19 m"
std::string describe_value(const hil::Requirement& requirement, const hil::Verdict& verdict) {
  if (!verdict.evaluated) return verdict.why;
  const std::string unit = requirement.unit.empty() ? "" : " " + requirement.unit;
  const double value = drop_rounding(verdict.value, std::min(kFar, std::abs(verdict.margin)));
  std::string uncertainty;
  if (verdict.is_uncertain() && verdict.is_error_known()) uncertainty = format(" ± %.2g", verdict.uncertainty);
  return to_short_text(value) + uncertainty + unit + (verdict.is_error_known() ? "" : " (± not known)") + " at " +
         to_short_text(verdict.time) + " s, " + describe_limit(requirement) + ", margin " +
         to_short_text(verdict.margin) + unit + (verdict.at_ticks ? "; as sampled at ticks and events" : "") +
         (verdict.leaves_out_blow() ? "; without the impulse of the blow at " + to_short_text(verdict.blow) + " s"
                                    : "");
}

// For plots: the kind of quantity, its row or "size", and the body that it is relative to.
Json build_subject(const hil::Requirement& requirement, const Model& model) {
  using Measure = hil::Requirement::Measure;
  using Take = hil::Requirement::Take;
  const std::string kind = hil::get_quantity_name(requirement.quantity);
  const bool of_joint = requirement.quantity == Measure::kReaction || requirement.quantity == Measure::kDisplacement ||
                        requirement.quantity == Measure::kAngle || requirement.quantity == Measure::kSpeed;
  std::string row = requirement.direction.isZero(0) ? "size" : "along";
  if (of_joint && requirement.axis >= 0) row = kRowNames[requirement.axis];
  if (of_joint && requirement.axis < 0) row = requirement.axis == hil::Requirement::kForce ? "force" : "moment";
  static constexpr const char* kTakes[] = {"minimum", "maximum", "peak", "final", "both"};
  Json json = {
      {"kind", kind}, {"row", row}, {"take", kTakes[static_cast<std::size_t>(static_cast<Take>(requirement.take))]}};
  if (requirement.quantity == Measure::kClearance || requirement.quantity == Measure::kRate ||
      requirement.quantity == Measure::kVelocity || requirement.quantity == Measure::kPosition)
    json["relative_to"] = get_body_name(model, requirement.b);
  return json;
}

const char* get_word(const hil::Verdict& verdict) {
  if (!verdict.is_resolved()) return "unresolved";
  return verdict.is_met() ? "met" : verdict.evaluated ? "not met" : "not evaluated";
}

// Lengths of columns are those of characters, not of UTF-8's bytes.
std::string pad(const std::string& text, std::size_t width) {
  const std::size_t length = count_characters(text);
  return text + std::string(width > length ? width - length : 0, ' ');
}

// "times that a required participant was lost: 1, at most 0"
std::string describe_value(const SessionVerdict& limit) {
  return limit.text + ": " + to_short_text(limit.value) +
         (std::isfinite(limit.most) ? ", at most " + to_short_text(limit.most) : ", no limit");
}

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// Commands of participants of which nothing came: what one says twice, and what strangers say, is none of these; nor,
// where one was lost, are commands for ticks that are over, which it sends when it comes back.
std::int64_t count_refused(const hil::TimingSummary& timing, bool any_lost) {
  using enum hil::Reject;
  std::int64_t sum = 0;
  for (const hil::Reject reason :
       {kPastTick, kExpired, kNotFinite, kOutOfRange, kUnknownChannel, kTooFar, kNoPlace, kJump})
    if (!any_lost || reason != kPastTick) sum += timing.rejected[static_cast<std::size_t>(reason)];
  return sum;
}

}  // namespace

std::vector<SessionVerdict> judge_session(const RunReport& report) {
  std::vector<SessionVerdict> list;
  if (report.notices.empty()) return list;
  const hil::FlightSoftware::Limits& limits = report.scenario.flight_software.limits;
  // Under the policy `pause` simulated time waits for it: nothing is lost.
  const auto is_loss = [](const hil::EventMessage& notice) {
    const std::string_view name = hil::get_name(notice.name);
    return name.starts_with(hil::kPolicyPrefix) && !name.ends_with("pause");
  };
  const auto lost = std::ranges::count_if(report.notices, is_loss);
  list.push_back({"flight_software.lost", "times that a required participant was lost", static_cast<double>(lost),
                  static_cast<double>(limits.lost)});
  const hil::TimingSummary& timing = report.timing;
  // What has no limit is listed where there is any of it.
  const auto add = [&list](const char* id, const char* text, double value, double most) {
    if (std::isfinite(most) || value > 0) list.push_back({id, text, value, most});
  };
  const auto to_most = [](const std::optional<int>& limit) { return limit ? *limit : kNoLimit; };
  const double ticks = static_cast<double>(std::max<std::int64_t>(1, report.tick));
  add("flight_software.refused", "commands that were refused", static_cast<double>(count_refused(timing, lost > 0)),
      limits.refused);
  add("flight_software.late", "late commands, as a part of the ticks",
      static_cast<double>(timing.late_commands) / ticks, limits.late < 1 ? limits.late : kNoLimit);
  add("flight_software.unused", "commands for ticks after the end", static_cast<double>(timing.unused_commands),
      to_most(limits.unused));
  add("flight_software.malformed", "malformed messages",
      static_cast<double>(timing.rejected[static_cast<std::size_t>(hil::Reject::kMalformed)]),
      to_most(limits.malformed));
  add("flight_software.overruns", "ticks that ended after the next was due", static_cast<double>(timing.overruns),
      to_most(limits.overruns));
  return list;
}

bool is_met(const RunReport& report) {
  for (const SessionVerdict& limit : judge_session(report))
    if (!limit.is_met()) return false;
  const std::vector<hil::Verdict> verdicts = report.analysis.judge();
  return std::all_of(verdicts.begin(), verdicts.end(), [](const hil::Verdict& verdict) { return verdict.is_met(); });
}

void print_requirements(std::FILE* to, const RunReport& report) {
  const std::vector<hil::Verdict> verdicts = report.analysis.judge();
  if (verdicts.empty()) return;
  std::fprintf(to, "\n%s\n", paint(to, Colour::kBold, "Requirements").c_str());
  std::size_t width = 0;
  for (const hil::Verdict& verdict : verdicts) width = std::max(width, get(report, verdict).id.size());
  std::size_t missed = 0, unresolved = 0;
  for (const hil::Verdict& verdict : verdicts) {
    const hil::Requirement& requirement = get(report, verdict);
    missed += verdict.is_resolved() && !verdict.is_met();
    unresolved += !verdict.is_resolved();
    const std::string word = paint(to, verdict.is_met() ? Colour::kGreen : Colour::kRed, pad(get_word(verdict), 13));
    std::fprintf(to, "  %s  %s  %s\n", pad(requirement.id, width).c_str(), word.c_str(),
                 describe_value(requirement, verdict).c_str());
    const std::string what = hil::describe_quantity(requirement, report.scenario.model);
    std::fprintf(to, "  %s                 %s\n", std::string(width, ' ').c_str(),
                 (requirement.text.empty() ? what : requirement.text + " (" + what + ")").c_str());
    if (!verdict.is_resolved())
      std::fprintf(to, "  %s                 depends on %s\n", std::string(width, ' ').c_str(),
                   verdict.unresolved.c_str());
  }
  const std::string count = missed == 0
                                ? "all requirements are met"
                                : std::to_string(missed) + " of " + tools::count(verdicts.size(), "requirement") +
                                      (missed == 1 ? " is" : " are") + " not met";
  if (unresolved > 0)
    std::fprintf(to, "  %s\n",
                 paint(to, Colour::kRed,
                       std::to_string(unresolved) + " of " + tools::count(verdicts.size(), "requirement") +
                           (unresolved == 1 ? " is" : " are") + " unresolved: neither met nor missed")
                     .c_str());
  if (missed > 0 || unresolved == 0)
    std::fprintf(to, "  %s\n", paint(to, missed == 0 ? Colour::kGreen : Colour::kRed, count).c_str());
}

void print_session_verdicts(std::FILE* to, const RunReport& report) {
  const std::vector<SessionVerdict> verdicts = judge_session(report);
  if (verdicts.empty()) return;
  std::fprintf(to, "\n%s\n", paint(to, Colour::kBold, "Limits of the session (flight_software.require)").c_str());
  for (const SessionVerdict& limit : verdicts)
    std::fprintf(
        to, "  %s  %s  %s\n", pad(limit.id, 24).c_str(),
        paint(to, limit.is_met() ? Colour::kGreen : Colour::kRed, limit.is_met() ? "met    " : "not met").c_str(),
        describe_value(limit).c_str());
}

nlohmann::ordered_json build_session_verdicts_json(const RunReport& report) {
  Json list = Json::array();
  for (const SessionVerdict& limit : judge_session(report))
    list.push_back({{"id", limit.id},
                    {"text", limit.text},
                    {"met", limit.is_met()},
                    {"value", limit.value},
                    {"at_most", std::isfinite(limit.most) ? Json(limit.most) : Json(nullptr)}});
  return list;
}

nlohmann::ordered_json build_requirements_json(const RunReport& report) {
  Json list = Json::array();
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  for (const hil::Verdict& verdict : report.analysis.judge()) {
    const hil::Requirement& requirement = get(report, verdict);
    Json entry = {{"id", requirement.id},
                  {"text", requirement.text},
                  {"quantity", hil::describe_quantity(requirement, report.scenario.model)},
                  {"unit", requirement.unit},
                  {"met", verdict.is_met()},
                  {"evaluated", verdict.evaluated},
                  {"resolved", verdict.is_resolved()}};
    if (!verdict.is_resolved()) entry["unresolved"] = verdict.unresolved;
    if (verdict.evaluated) {
      entry["value"] = verdict.value;
      entry["limit"] = verdict.limit;
      entry["margin"] = verdict.margin;
      entry["t"] = verdict.time;
      if (verdict.is_uncertain()) entry["uncertainty"] = number(verdict.uncertainty);
      if (verdict.at_ticks) entry["at_ticks"] = true;
      if (verdict.leaves_out_blow()) entry["without_blow"] = verdict.blow;
    } else {
      entry["why"] = verdict.why;
    }
    entry["of"] = build_subject(requirement, report.scenario.model);
    entry["at_least"] = number(requirement.least);
    entry["at_most"] = number(requirement.most);
    list.push_back(std::move(entry));
  }
  return list;
}

void write_junit(const RunReport& report, const std::string& target, double seconds) {
  if (target.empty()) return;
  const std::vector<hil::Verdict> verdicts = report.analysis.judge();
  const std::vector<SessionVerdict> limits = judge_session(report);
  const auto failed = static_cast<std::size_t>(std::count_if(
                          verdicts.begin(), verdicts.end(),
                          [](const hil::Verdict& verdict) { return verdict.is_resolved() && !verdict.is_met(); })) +
                      static_cast<std::size_t>(std::count_if(
                          limits.begin(), limits.end(), [](const SessionVerdict& limit) { return !limit.is_met(); }));
  const auto unresolved = static_cast<std::size_t>(std::count_if(
      verdicts.begin(), verdicts.end(), [](const hil::Verdict& verdict) { return !verdict.is_resolved(); }));
  const bool ok = report.status == "ok";
  const std::string time = format("%.3f", seconds);
  const std::string name = hil::escape_xml(report.scenario.name);
  const std::string counts = "tests=\"" + std::to_string(verdicts.size() + limits.size() + 1) + "\" failures=\"" +
                             std::to_string(failed) + "\" errors=\"" + std::to_string(unresolved + (ok ? 0 : 1)) + "\"";
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites " + counts + ">\n <testsuite name=\"" +
                    name + "\" " + counts + " skipped=\"0\" time=\"" + time + "\">\n  <testcase classname=\"" + name +
                    "\" name=\"run\" time=\"" + time + "\">\n";
  if (!ok)
    xml += "   <error type=\"" + hil::escape_xml(report.status) + "\" message=\"" + hil::escape_xml(report.message) +
           "\"/>\n";
  xml += "  </testcase>\n";
  for (const hil::Verdict& verdict : verdicts) {
    const hil::Requirement& requirement = get(report, verdict);
    const std::string value = hil::escape_xml(describe_value(requirement, verdict));
    const std::string what = hil::describe_quantity(requirement, report.scenario.model);
    xml += "  <testcase classname=\"" + name + "\" name=\"" + hil::escape_xml(requirement.id) + "\">\n";
    if (!verdict.is_resolved()) {
      xml += "   <error type=\"unresolved\" message=\"" + hil::escape_xml(verdict.unresolved) + "\"/>\n";
    } else if (!verdict.is_met()) {
      xml += "   <failure type=\"" + std::string(verdict.evaluated ? "not met" : "not evaluated") + "\" message=\"" +
             value + "\"/>\n";
    }
    xml += "   <system-out>" + hil::escape_xml(requirement.text.empty() ? what : requirement.text + " (" + what + ")") +
           ": " + value + "</system-out>\n  </testcase>\n";
  }
  for (const SessionVerdict& limit : limits) {
    const std::string value = describe_value(limit);
    xml += "  <testcase classname=\"" + name + "\" name=\"" + limit.id + "\">\n";
    if (!limit.is_met()) xml += "   <failure type=\"not met\" message=\"" + value + "\"/>\n";
    xml += "   <system-out>" + value + "</system-out>\n  </testcase>\n";
  }
  write_text(xml + " </testsuite>\n</testsuites>\n", target);
}

}  // namespace unlatch::tools
