#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "tools/common/output.h"
#include "tools/common/shape_json.h"
#include "tools/common/text.h"
#include "tools/export/output_json.h"
#include "tools/unlatch/results/accuracy_report.h"
#include "tools/unlatch/results/finding_report.h"
#include "tools/unlatch/results/redundancy.h"
#include "tools/unlatch/results/report.h"
#include "tools/unlatch/results/verdict_report.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;
using tools::to_json;

// At each sample everything.
Json build_samples(const RunReport& report) {
  Json json = Json::array();
  const std::vector<hil::Output>& list = report.outputs->reader().list();
  std::vector<std::size_t> all(list.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (const hil::RunOutputs::Sample& sample : report.outputs->get_samples()) {
    Json entry = {{"t", sample.time}};
    entry.update(build_outputs_json(report.outputs->reader(), report.scenario.model, all, sample.values));
    json.push_back(std::move(entry));
  }
  return json;
}

// Each group as a table: a row of numbers for each time; of a joint's mode its index.
Json build_series(const RunReport& report) {
  Json json = Json::array();
  for (const hil::RunOutputs::Series& series : report.outputs->get_series()) {
    const std::vector<hil::Output>& list = report.outputs->reader().list();
    std::size_t width = 0;
    for (const std::size_t i : series.selected.outputs) width += list[i].columns.size();
    Json rows = Json::array();
    for (std::size_t row = 0; row < series.times.size(); ++row) {
      const auto first = series.values.begin() + static_cast<std::ptrdiff_t>(row * width);
      rows.push_back(std::vector<double>(first, first + static_cast<std::ptrdiff_t>(width)));
    }
    json.push_back({{"every", series.selected.rate.every},
                    {"outputs", build_output_list_json(list, series.selected.outputs)},
                    {"t", series.times},
                    {"rows", rows}});
  }
  return json;
}

Json build_clearance(const hil::Clearance& clearance, const hil::PairDistance& at) {
  Json json = {{"pair", Json::array({clearance.name_a, clearance.name_b})},
               {"min", clearance.smallest},
               {"t", clearance.time},
               {"tie", {clearance.tie.from, clearance.tie.to}},
               {"witnesses", {to_json(at.least.on_a), to_json(at.least.on_b)}},
               {"normal", to_json(at.least.normal)},
               {"shapes", {at.shape_a, at.shape_b}},
               {"method", hil::get_method_name(clearance.method)},
               {"touch", clearance.touch ? Json(*clearance.touch) : Json(nullptr)}};
  if (clearance.after_release) {
    json["after_release"] = {{"from", clearance.after_release->from},
                             {"min", clearance.after_release->smallest},
                             {"t", clearance.after_release->time}};
  }
  return json;
}

Json build_contact(const hil::ContactRecord& contact) {
  const auto time = [](const std::optional<double>& t) { return t ? Json(*t) : Json(nullptr); };
  Json list = Json::array();
  for (const hil::Touch& touch : contact.list)
    list.push_back({{"t", touch.time},
                    {"at_start", touch.at_start},
                    {"lift", time(touch.lift)},
                    {"duration", touch.duration},
                    {"shapes", touch.pairs},
                    {"peak_force", touch.peak_force},
                    {"peak_t", touch.peak_time},
                    {"depth", touch.depth},
                    {"impulse", touch.impulse}});
  return {{"name", contact.name},
          {"touch", time(contact.touch)},
          {"lift", time(contact.lift)},
          {"touches", contact.touches},
          {"closed_at_start", contact.closed_at_start},
          {"closed", contact.closed},
          {"duration", contact.duration},
          {"peak_force", contact.peak_force},
          {"t", contact.peak_time},
          {"depth", contact.depth},
          {"impulse", contact.totals.impulse},
          {"slip", contact.totals.slip},
          {"dissipated", contact.totals.dissipated},
          {"each", list}};
}

Json build_audit(const EventAudit& audit) {
  return {{"t", audit.time},
          {"before",
           {{"momentum", to_json(audit.before.momentum)},
            {"angular_momentum", to_json(audit.before.angular_momentum)},
            {"kinetic_energy", audit.before.kinetic}}},
          {"after",
           {{"momentum", to_json(audit.before.momentum + audit.jump.momentum)},
            {"angular_momentum", to_json(audit.before.angular_momentum + audit.jump.angular_momentum)},
            {"kinetic_energy", audit.before.kinetic + audit.jump.kinetic}}},
          {"momentum_jump", to_json(audit.jump.momentum)},
          {"angular_momentum_jump", to_json(audit.jump.angular_momentum)},
          {"energy_jump", audit.jump.kinetic},
          {"allowed",
           {{"momentum_jump", to_json(audit.allowed.momentum)},
            {"angular_momentum_jump", to_json(audit.allowed.angular_momentum)},
            {"energy_jump", audit.allowed.kinetic}}}};
}

Json to_json(const hil::DurationSummary& summary) {
  Json histogram = Json::array();
  for (const auto& bin : summary.bins) histogram.push_back(Json::array({bin.upper_ns, bin.count}));
  return {{"min", summary.min},     {"p50", summary.p50},     {"p90", summary.p90},       {"p99", summary.p99},
          {"p999", summary.p999},   {"p9999", summary.p9999}, {"p99999", summary.p99999}, {"max", summary.max},
          {"count", summary.count}, {"histogram", histogram}};
}

Json to_json(const hil::Overrun& overrun) {
  const hil::TickTiming& timing = overrun.timing;
  return {{"tick", timing.tick},
          {"cause", hil::kOverrunCauseNames[static_cast<std::size_t>(overrun.cause)]},
          {"late_ns", overrun.late_ns},
          {"wakeup_ns", timing.wakeup_ns},
          {"input_ns", timing.input_ns},
          {"step_ns", timing.step_ns},
          {"output_ns", timing.output_ns},
          {"substeps", timing.substeps},
          {"page_faults", overrun.page_faults},
          {"faults_read", overrun.faults_read},
          {"preemptions", overrun.preemptions}};
}

Json to_json(const hil::TimingSummary& timing) {
  Json rejected = Json::object();
  for (std::size_t i = 0; i < hil::kRejectReasons; ++i) {
    rejected[std::string(hil::get_text(static_cast<hil::Reject>(i)))] = timing.rejected[i];
  }
  Json causes = Json::object(), worst = Json::array();
  for (std::size_t i = 0; i < hil::kOverrunCauses; ++i) {
    causes[std::string(hil::kOverrunCauseNames[i])] = timing.overrun_causes[i];
  }
  for (const hil::Overrun& overrun : timing.worst_overruns) worst.push_back(to_json(overrun));
  return {{"step_ns", to_json(timing.step)},
          {"wakeup_ns", to_json(timing.wakeup)},
          {"turnaround_ns", to_json(timing.turnaround)},
          {"round_trip_ns", to_json(timing.round_trip)},
          {"overruns", timing.overruns},
          {"overrun_causes", causes},
          {"worst_overruns", worst},
          {"slipped_ns", timing.slipped_ns},
          {"skipped_outputs", timing.skipped_outputs},
          {"late_commands", timing.late_commands},
          {"late_answers", timing.late_answers},
          {"unanswered", timing.unanswered},
          {"dropped", timing.dropped},
          {"resent", timing.resent},
          {"unused_commands", timing.unused_commands},
          {"rejected", rejected}};
}

Json to_json(const hil::ReplayResult& replay) {
  Json json = {{"ticks_compared", replay.compared}, {"agrees", replay.agrees()}};
  if (replay.difference) {
    json["first_difference"] = {{"tick", replay.difference->tick},
                                {"recorded", to_hex(replay.difference->recorded)},
                                {"replayed", to_hex(replay.difference->replayed)}};
  }
  if (!replay.mismatch.empty()) json["mismatch"] = replay.mismatch;
  return json;
}

}  // namespace

const char* get_status_name(hil::RunStatus status) {
  switch (status) {
    case hil::RunStatus::kDone:
      return "ok";
    case hil::RunStatus::kFaulted:
      return "fault";
    default:
      return "aborted";
  }
}

nlohmann::ordered_json build_json(const RunReport& report) {
  const Model& model = report.scenario.model;
  Json json = {{"schema", 1},
               {"scenario", report.scenario.name},
               {"status", report.status},
               {"dt", report.simulation.plan().get_options().dt},
               {"ticks", report.tick},
               {"hash", to_hex(report.hash)},
               {"model_hash", to_hex(report.simulation.get_model_hash())}};
  if (!report.message.empty()) json["message"] = report.message;
  json["events"] = Json::array();
  for (const auto& entry : report.analysis.timeline) {
    json["events"].push_back({{"t", entry.time}, {"name", entry.name}, {"subject", entry.subject}});
    if (!entry.shapes.empty()) json["events"].back()["shapes"] = entry.shapes;
    if (const double uncertainty = report.analysis.calc_time_uncertainty(entry);
        uncertainty > hil::TimelineEntry::kKnown)
      json["events"].back()["uncertainty"] = uncertainty;
  }
  json["notices"] = Json::array();
  for (const hil::EventMessage& notice : report.notices) {
    json["notices"].push_back(
        {{"t", notice.time}, {"name", hil::get_name(notice.name)}, {"subject", hil::get_name(notice.subject)}});
  }
  for (const hil::RunNotice& notice : report.analysis.accuracy().get()) {
    json["notices"].push_back({{"t", notice.time},
                               {"name", get_full_name(notice)},
                               {"subject", notice.subject},
                               {"text", notice.text},
                               {"worst_t", notice.worst_time},
                               {"unresolved", notice.unresolved}});
  }
  json["warnings"] = build_findings_json(report.scenario, list_warnings(report.scenario));
  json["session_events"] = Json::array();
  for (const hil::EventMessage& event : report.session_events)
    json["session_events"].push_back({{"t", event.time},
                                      {"tick", event.tick},
                                      {"name", hil::get_name(event.name)},
                                      {"subject", hil::get_name(event.subject)}});
  json["session_events_left_out"] = report.session_events_left_out;
  const hil::SearchTotals& search = report.analysis.search;
  json["search"] = {{"postponed", search.postponed},
                    {"unlocated", search.unlocated},
                    {"corners", search.corners},
                    {"unseen", search.unseen}};
  json["samples"] = Json::array();
  if (report.outputs != nullptr) {
    json["samples"] = build_samples(report);
    if (!report.outputs->get_series().empty()) json["outputs"] = build_series(report);
  }
  json["clearance"] = Json::array();
  for (std::size_t i = 0; i < report.analysis.clearances().size(); ++i) {
    json["clearance"].push_back(
        build_clearance(report.analysis.clearances()[i], report.analysis.calc_witnesses(static_cast<int>(i))));
  }
  json["contacts"] = Json::array();
  for (const hil::ContactRecord& contact : report.analysis.list_contacts())
    json["contacts"].push_back(build_contact(contact));
  json["verdict"] = build_requirements_json(report);
  json["session_limits"] = build_session_verdicts_json(report);
  json["separations"] = build_separations_json(report);
  json["tip_off"] = Json::array();
  for (const hil::TipOff& tip_off : report.analysis.tip_offs) {
    json["tip_off"].push_back(
        {{"t", tip_off.time}, {"body", tip_off.body}, {"joint", tip_off.joint}, {"w", to_json(tip_off.w)}});
  }
  json["joints"] = Json::object();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const auto mode = static_cast<std::size_t>(report.simulation.state().joints[i].mode);
    json["joints"][model.joints[i].name] = model.joints[i].modes[mode].name;
  }
  json["redundant"] = Json::array();
  for (const hil::SharedReactions& shared : report.analysis.shared) {
    Json entry = build_json(model, shared.rows);
    entry["from"] = shared.from;
    entry["until"] = shared.until;
    json["redundant"].push_back(entry);
  }
  json["audit"] = Json::array();
  for (const EventAudit& audit : report.analysis.audits) json["audit"].push_back(build_audit(audit));
  json["energy"] = build_energy_json(report.analysis.accuracy().get_energy());
  if (report.accuracy) {
    json["accuracy"] = build_accuracy_json(*report.accuracy);
    json["accuracy_step"] = build_step_json(*report.accuracy);
  }
  json["verdicts"] = build_verdicts(report);
  json["timing"] = to_json(report.timing);
  json["refused"] = report.refused;
  json["unfit"] = report.unfit;
  if (report.replay) json["replay"] = to_json(*report.replay);
  return json;
}

void write_json(const RunReport& report, const std::string& target) { write_json(build_json(report), target); }

}  // namespace unlatch::tools
