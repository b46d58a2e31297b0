// unlatch dossier: one page with what a review asks of a model's credibility, made from what the program knows.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "hil/run/run.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/dossier/data_json.h"
#include "tools/dossier/factors.h"
#include "tools/dossier/page.h"
#include "tools/dossier/sha256.h"
#include "tools/dossier/verification.h"
#include "tools/pages/pages.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/unlatch/dossier/dossier_parts.h"
#include "tools/unlatch/dossier/verbs.h"
#include "tools/unlatch/options/campaign_sample.h"
#include "tools/unlatch/options/scenario_notes.h"
#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/results/accuracy_report.h"

namespace unlatch::tools {
namespace {

namespace fs = std::filesystem;

struct DossierOptions {
  ScenarioOptions scenario;
  std::string results, statements, out, json;
  double tolerance = 1e-6;
  bool without_accuracy = false;
};

// What is reviewed: a scenario, or the scenario of a campaign with its results.
struct Subject {
  ScenarioOptions scenario;
  std::string file;                  // as given, without its folder
  std::vector<std::string> set;      // of the command line
  std::optional<CampaignData> data;  // of a campaign
};

void refuse_other_results(const DossierOptions& options, const hil::Campaign& campaign, const CampaignData& data) {
  const hil::Scenario& scenario = campaign.tree->get_nominal();
  const Json& manifest = data.manifest;
  if (manifest.at("campaign_text").get<std::string>() == campaign.text &&
      manifest.at("scenario_text").get<std::string>() == scenario.text &&
      manifest.at("overrides").get<std::vector<std::string>>() == scenario.overrides)
    return;
  refuse_option("--results",
                options.results + " is of another campaign or scenario text, or another --set: run the campaign again");
}

Subject find_subject(const DossierOptions& options) {
  Subject subject{
      options.scenario, fs::path(options.scenario.path).filename().string(), options.scenario.overrides, {}};
  if (!is_campaign(options.scenario)) {
    if (!options.results.empty()) refuse_option("--results", "it belongs to a campaign file");
    return subject;
  }
  if (options.results.empty())
    refuse_option("--results",
                  "of a campaign its folder is needed: unlatch campaign FILE --out DIR, then --results DIR");
  if (options.scenario.dt > 0 || options.scenario.until > 0)
    refuse_option(options.scenario.dt > 0 ? "--dt" : "--until",
                  "the samples of a campaign have their own; use its `set`");
  const hil::Campaign campaign = hil::load_campaign(options.scenario.path, options.scenario.overrides);
  try {
    subject.data = read_campaign(options.results);
  } catch (const hil::ResultError& error) {
    refuse_option("--results", error.what());
  }
  refuse_other_results(options, campaign, *subject.data);
  subject.scenario.path = campaign.scenario;
  subject.scenario.overrides = campaign.tree->get_nominal().overrides;
  return subject;
}

// The nominal run and its accuracy. Nothing: a signal ended it.
class Flight {
 public:
  Flight(const Subject& subject, const DossierOptions& options)
      : scenario(load(subject.scenario)),
        simulation_(hil::build_simulation(scenario)),
        analysis_(scenario, *simulation_) {
    const std::int64_t last = calc_last_tick(scenario);
    Progress progress(scenario.dt, last);
    end_ = hil::run_fast(*simulation_, analysis_, nullptr, last, catch_interrupts(),
                         [&] { progress.show(simulation_->get_tick()); });
    progress.clear();
    if (end_.status == hil::RunStatus::kDone) compare_steps(subject, options);
  }

  [[nodiscard]] RunReport build_report() const {
    RunReport report{scenario,     *simulation_, analysis_, get_status_name(end_.status),
                     end_.message, end_.tick,    end_.hash, end_.timing,
                     {},           std::nullopt};
    report.accuracy = accuracy_;
    tell_unresolved(analysis_, report.status, report.message);
    return report;
  }

  const hil::Scenario scenario;
  std::string skipped = "the run did not end well";  // why there is no comparison of steps

 private:
  void compare_steps(const Subject& subject, const DossierOptions& options) {
    constexpr double kNano = 1e9;
    if (options.without_accuracy) {
      skipped = "it was left out (--without-accuracy)";
    } else if (std::llround(scenario.dt * kNano) % 4 != 0) {
      skipped = "the step has no half and quarter in whole nanoseconds";
    } else {
      accuracy_ = measure_accuracy(subject.scenario, scenario, *simulation_, analysis_, options.tolerance);
      measure_growth(subject.scenario, scenario, *simulation_, *accuracy_);
    }
  }

  std::unique_ptr<hil::Simulation> simulation_;
  hil::RunAnalysis analysis_;
  hil::LogEnd end_;
  std::optional<hil::AccuracyReport> accuracy_;
};

// Commands that give the numbers again, in the scenario's folder, with the hash that they end in.
Json build_commands(const Subject& subject, const DossierOptions& options, const Json& document) {
  const auto write_scenario = [&](const std::string& file, const std::vector<std::string>& overrides) {
    std::string text = quote_word(file);
    for (const std::string& one : overrides) text += " --set " + quote_word(one);
    if (options.scenario.dt > 0) text += " --dt " + format("%.17g", options.scenario.dt);
    if (options.scenario.until > 0) text += " --until " + format("%.17g", options.scenario.until);
    return text;
  };
  const std::string nominal =
      write_scenario(fs::path(subject.scenario.path).filename().string(), subject.scenario.overrides);
  const Json& run = document.at("run");
  Json list = Json::array();
  const auto add = [&](const std::string& what, const std::string& command, const Json& hash) {
    list.push_back({{"what", what}, {"command", command}, {"hash", hash}});
  };
  add("the mistakes and findings of the scenario", "unlatch check " + nominal, run.at("model_hash"));
  add("the nominal run: requirements, notices, energy", "unlatch run " + nominal, run.at("hash"));
  if (!run.at("accuracy").contains("skipped"))
    add("the errors of the step", "unlatch run " + nominal + " --accuracy " + format("%g", options.tolerance),
        run.at("hash"));
  if (subject.data) {
    const std::string file = write_scenario(subject.file, subject.set);
    add("the campaign: probabilities, sensitivities", "unlatch campaign " + file + " --out RESULTS",
        document.at("campaign").at("hash"));
  }
  add("this dossier, byte for byte",
      "unlatch dossier " + write_scenario(subject.file, subject.set) + (subject.data ? " --results RESULTS" : "") +
          (options.statements.empty()
               ? ""
               : " --statements " + quote_word(fs::path(options.statements).filename().string())) +
          (options.without_accuracy ? " --without-accuracy" : "") + " --out dossier.html",
      nullptr);
  return list;
}

void add_evidence(const hil::Scenario& scenario, const hil::ScenarioRecord& record, const Json& verification,
                  Evidence& evidence) {
  evidence["data_pedigree"].push_back(
      "Data of the model: " + describe(count_basis(record, hil::DataValue::Role::kModel)) + ".");
  evidence["input_pedigree"].push_back("Inputs: " + describe(count_basis(record, hil::DataValue::Role::kInput)) + ".");
  const std::string absent = hil::describe_absence(scenario.flight_software, "the runs of this dossier");
  if (!absent.empty()) evidence["input_pedigree"].push_back(absent + ".");
  evidence["verification"].push_back(
      verification.at("program").get<std::string>() + ", commit " + verification.at("commit").get<std::string>() +
      ": " + count(verification.at("verified").size(), "system") +
      " compared with other solutions of their equations, " + count(verification.at("promises").size(), "promise") +
      " with tests, " + count(verification.at("known_to_be_wrong").size(), "limit") + " known to be wrong.");
  evidence["validation"].push_back(
      "The program has no measurements of this system. What of its models is not validated, and what published flights "
      "say, is listed below.");
  evidence["management"].push_back(
      "The text of the scenario is in this page; its hashes and the commands below give every number again, to the "
      "bit, on any machine.");
}

// The document without its own hash, which is of this text.
std::string write_contents(const Json& document) {
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json build_document(const Subject& subject, const DossierOptions& options, const Flight& flight) {
  const Statements statements = read_statements(options.statements);
  const hil::Scenario& scenario = flight.scenario;
  const hil::ScenarioRecord record = hil::load_record(scenario);
  Evidence evidence;
  Json document = {{"format", 1},
                   {"program", "unlatch " UNLATCH_VERSION},
                   {"scenario", scenario.name},
                   {"title", scenario.title},
                   {"file", subject.file},
                   {"intended_use", statements.intended_use},
                   {"author", statements.author}};
  document["verification"] = build_verification_json();
  add_evidence(scenario, record, document.at("verification"), evidence);
  document["data"] = build_data_json(scenario, record);
  document["run"] = build_run_part(flight.build_report(), record, flight.skipped, evidence);
  if (subject.data) {
    std::string command = "unlatch run " + quote_word(subject.file);
    for (const std::string& one : subject.set) command += " --set " + quote_word(one);
    document["campaign"] = build_campaign_part(*subject.data, command + " --results RESULTS --sample ", evidence);
  }
  document["factors"] = build_factors_json(statements, evidence);
  document["commands"] = build_commands(subject, options, document);
  document["scenario_text"] = scenario.text;
  document["overrides"] = scenario.overrides;
  return document;
}

// What is in the page, in some lines.
void print_summary(std::FILE* to, const Json& document) {
  const Json& requirements = document.at("run").at("requirements");
  const auto met = std::ranges::count_if(requirements, [](const Json& one) { return one.at("met").get<bool>(); });
  std::fprintf(to, "%s: %s; %lld of %s met\n", document.at("scenario").get<std::string>().c_str(),
               document.at("run").at("status").get<std::string>().c_str(), static_cast<long long>(met),
               count(requirements.size(), "requirement").c_str());
  for (const Json& factor : document.at("factors"))
    for (const Json& text : factor.at("evidence"))
      std::fprintf(to, "  %s: %s\n", factor.at("name").get<std::string>().c_str(), text.get<std::string>().c_str());
}

int run(const DossierOptions& options) {
  if (options.out.empty() && options.json.empty()) refuse_missing("--out");
  if (!options.out.empty() && !has_pages()) {
    std::fprintf(stderr, "unlatch dossier: %s\n", kNoPages);
    return kExitEnvironment;
  }
  if (!options.out.empty()) check_output(options.out);
  check_output(options.json);
  (void)read_statements(options.statements);  // its mistakes before the runs
  const Subject subject = find_subject(options);
  const Flight flight(subject, options);
  if (catch_interrupts()) {
    std::fprintf(stderr, "interrupted; nothing was written\n");
    return kExitFailed;
  }
  Json document = build_document(subject, options, flight);
  const std::string contents = write_contents(document);
  const std::string hash = calc_sha256(contents);
  print_summary(get_people_stream(options.json), document);
  if (!options.json.empty()) write_text(contents, options.json);
  document["sha256"] = hash;
  if (!options.out.empty()) write_text(build_dossier_page(document), options.out);
  std::fprintf(stderr, "%s%ssha256 of the contents (--json): %s\n", options.out.c_str(),
               options.out.empty() ? "" : ": ", hash.c_str());
  const bool met = std::ranges::all_of(document.at("run").at("requirements"),
                                       [](const Json& one) { return one.at("met").get<bool>(); });
  return document.at("run").at("status") == "ok" && met ? kExitDone : kExitFailed;
}

}  // namespace

void add_dossier(Command app, int& exit_code) {
  auto options = std::make_shared<DossierOptions>();
  Command command = app.add_verb(
      "dossier",
      "Writes one page for a review of the model's credibility, by the factors of NASA-STD-7009: the basis of each "
      "value and "
      "the values that have none, what verifies this version, the errors of the step, requirements with their "
      "verdicts, "
      "notices and findings, of a campaign probabilities and sensitivities, and the commands and hashes that give "
      "every "
      "number again. What the program cannot know (validation by measurements, use, people) is taken from "
      "--statements. The "
      "same files give the same bytes. Exit code 1: the nominal run did not end well or missed a requirement, as `run` "
      "says, or a signal ended the work.",
      "unlatch dossier hil/scenarios/boosters/scenario.yaml --out dossier.html\n"
      "unlatch dossier scenario.yaml --statements statements.yaml --out dossier.html --json dossier.json\n"
      "unlatch dossier campaign.yaml --results results --out dossier.html");
  add_scenario_options(command, options->scenario);
  command.add_option("--out", options->out, "the page (.html)").type_name("FILE");
  command.add_option("--results", options->results, "of a campaign: the folder that `unlatch campaign` wrote")
      .type_name("DIR");
  command
      .add_option(
          "--statements", options->statements,
          "what the author states: a YAML file with intended_use, author, and for each factor a text, or {level: 0 to "
          "4, text}; the factors: data_pedigree, verification, validation, input_pedigree, uncertainty, robustness, "
          "use_history, management, people")
      .type_name("FILE");
  command
      .add_option("--tolerance", options->tolerance, "of the largest step that is found, relative to each value's size")
      .within(1e-15, 0.5)
      .type_name("TOLERANCE")
      .default_shown();
  command.add_flag("--without-accuracy", options->without_accuracy,
                   "leaves out the runs at half and a quarter of the step");
  command.add_json_option(options->json, "the contents of the page, which states the SHA-256 of this file");
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
