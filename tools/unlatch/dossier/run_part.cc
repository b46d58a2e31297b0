// The nominal run, as a part of the dossier.
#include <algorithm>
#include <cmath>

#include "hil/run/findings/findings.h"
#include "tools/common/text.h"
#include "tools/dossier/data_json.h"
#include "tools/requirements/requirement_list.h"
#include "tools/unlatch/dossier/dossier_parts.h"
#include "tools/unlatch/results/accuracy_report.h"
#include "tools/unlatch/results/finding_report.h"
#include "tools/unlatch/results/verdict_report.h"

namespace unlatch::tools {
namespace {

// Requirements with their verdicts, in the words that people read.
Json build_requirements(const RunReport& report, const hil::ScenarioRecord& record, Evidence& evidence) {
  Json list = build_requirements_json(report);
  std::size_t met = 0, unresolved = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    Json& one = list[i];
    one["parent"] = record.requirements[i].parent;
    one["rationale"] = record.requirements[i].rationale;
    one["criterion"] = describe_limit(report.scenario.requirements[i]);
    const bool resolved = one.at("resolved"), is_met = one.at("met");
    one["verdict"] = !resolved ? "unresolved" : is_met ? "met" : one.at("evaluated") ? "not met" : "not evaluated";
    met += is_met ? 1 : 0;
    unresolved += resolved ? 0 : 1;
  }
  if (!list.empty())
    evidence["robustness"].push_back("In the nominal run " + std::to_string(met) + " of " +
                                     count(list.size(), "requirement") + (met == 1 ? " is" : " are") + " met; " +
                                     std::to_string(unresolved) +
                                     " unresolved. Margins are in the table of requirements.");
  return list;
}

Json build_notices(const RunReport& report) {
  Json list = Json::array();
  for (const hil::RunNotice& notice : report.analysis.accuracy().get())
    list.push_back({{"t", notice.time},
                    {"name", get_full_name(notice)},
                    {"subject", notice.subject},
                    {"text", notice.text},
                    {"unresolved", notice.unresolved}});
  return list;
}

Json build_findings(const hil::Scenario& scenario) {
  Json list = build_findings_json(scenario, list_warnings(scenario));
  for (Json& finding : list) {
    if (!finding.contains("file")) continue;
    const auto at = std::ranges::find(scenario.files, finding.at("file").get<std::string>());
    finding["file"] = get_name_from_folder(scenario, static_cast<int>(at - scenario.files.begin()));
  }
  return list;
}

// What the comparison of three steps says, and how far the start decides.
void add_accuracy_evidence(const hil::AccuracyReport& accuracy, double dt, Evidence& evidence) {
  if (!accuracy.mismatch.empty()) {
    evidence["uncertainty"].push_back(
        "Numerical error: not known, since the runs at smaller steps differ: " + accuracy.mismatch + ".");
    return;
  }
  std::size_t unsettled = 0;
  double largest = 0;
  std::string of;
  for (const hil::AccuracyEntry& entry : accuracy.entries) {
    unsettled += entry.settles ? 0 : 1;
    const double relative = entry.value.size > 0 ? entry.error / entry.value.size : 0;
    if (relative <= largest) continue;
    largest = relative;
    of = entry.value.what;
  }
  evidence["uncertainty"].push_back("Numerical error, from runs at " + to_short_text(dt) +
                                    " s, its half and its quarter: at most " + to_short_text(largest) +
                                    " of a value's size" + (of.empty() ? "" : " (" + of + ")") + "; " +
                                    std::to_string(unsettled) + " of " + count(accuracy.entries.size(), "result") +
                                    (unsettled == 1 ? " does" : " do") + " not converge as expected.");
  if (accuracy.growth_measured)
    evidence["robustness"].push_back(
        accuracy.growth.empty()
            ? "No error of the start grows beyond what free motion explains."
            : "Errors of the start grow in " + count(accuracy.growth.size(), "body") + ", up to " +
                  to_short_text(std::ranges::max_element(accuracy.growth, {}, &hil::StartGrowth::factor)->factor) +
                  " times what free motion explains.");
}

Json build_accuracy(const RunReport& report, const std::string& skipped, Evidence& evidence) {
  if (!report.accuracy) {
    evidence["uncertainty"].push_back("Numerical error: not estimated, because " + skipped + ".");
    return {{"skipped", skipped}};
  }
  add_accuracy_evidence(*report.accuracy, report.simulation.plan().get_options().dt, evidence);
  Json json = build_step_json(*report.accuracy);
  json["values"] = build_accuracy_json(*report.accuracy);
  return json;
}

}  // namespace

std::string quote_word(const std::string& word) {
  const bool plain = std::ranges::all_of(word, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-./=:,+").find(c) != std::string_view::npos;
  });
  if (plain && !word.empty()) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

Json build_run_part(const RunReport& report, const hil::ScenarioRecord& record, const std::string& skipped_accuracy,
                    Evidence& evidence) {
  const hil::EnergyBalance& energy = report.analysis.accuracy().get_energy();
  Json json = {{"status", report.status},
               {"message", report.message},
               {"dt", report.simulation.plan().get_options().dt},
               {"ticks", report.tick},
               {"t", report.simulation.get_time()},
               {"hash", to_hex(report.hash)},
               {"model_hash", to_hex(report.simulation.get_model_hash())},
               {"requirements", build_requirements(report, record, evidence)}};
  json["accuracy"] = build_accuracy(report, skipped_accuracy, evidence);
  json["notices"] = build_notices(report);
  json["findings"] = build_findings(report.scenario);
  json["energy"] = build_energy_json(energy);
  if (energy.scale > 0)
    evidence["verification"].push_back("Of this run: energy that no force explains is at most " +
                                       to_short_text(std::abs(energy.largest) / energy.scale) +
                                       " of the largest energy.");
  evidence["uncertainty"].push_back(count(json.at("notices").size(), "notice") +
                                    " that the step does not resolve something, " +
                                    count(json.at("findings").size(), "finding") + " on the scenario.");
  return json;
}

}  // namespace unlatch::tools
