// unlatch report: one HTML file with everything that one recording, or two, can show.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/pages/pages.h"
#include "tools/program/exit_codes.h"
#include "tools/report/page.h"
#include "tools/report/structure.h"
#include "tools/unlatch/recordings/diff_report.h"
#include "tools/unlatch/recordings/replayed_log.h"
#include "tools/unlatch/recordings/verbs.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

// Bytes of all frames of a page before their encoding, which adds a third: with the page itself, a file below 5 MB.
constexpr std::size_t kFrameBudget = 2'600'000;

struct ReportOptions {
  std::vector<std::string> logs;
  std::string out;
};

// The output of `unlatch replay`.
std::string build_summary(const RunReport& report) {
  char* text = nullptr;
  std::size_t length = 0;
  std::FILE* const stream = open_memstream(&text, &length);
  if (stream == nullptr) throw OutputError("no memory for the summary");
  print_report(stream, report);
  std::fclose(stream);
  const std::unique_ptr<char, decltype(&std::free)> owner(text, &std::free);
  return {text, length};
}

void add_provenance(const hil::LogHeader& header, const hil::Scenario& scenario, Json& run) {
  run["title"] = scenario.title;
  run["program"] = header.program;
  run["compiler"] = header.compiler;
  run["pace"] = hil::get_text(header.pace);
  run["first_tick"] = header.first_tick;
  run["planned_tick"] = header.last_tick;
  run["model_hash"] = to_hex(header.model_hash);
  run["scenario_path"] = header.scenario_path;
  run["scenario_text"] = header.scenario_text;
  run["overrides"] = header.overrides;
}

// One recording, replayed with a progress line. `sound` becomes false if it does not replay as recorded.
Json build_run(const std::string& path, std::size_t budget, bool& sound) {
  ReplayedLog log(path);
  const hil::LogHeader& header = log.opened.recording.header;
  const hil::Simulation& simulation = *log.opened.simulation;
  FrameRecorder frames(log.opened.scenario, simulation, log.analysis, hil::get_sensors_shown(header));
  Progress progress(header.dt, header.last_tick);
  log.replay([&](const StepReport& step) {
    frames.look(step, log.opened.recording.received);
    progress.show(simulation.get_tick());
  });
  progress.clear();
  sound = sound && log.is_sound();

  const RunReport report = log.build_report();
  Json run = build_json(report);
  run.erase("samples");
  run["log"] = path;
  add_provenance(header, log.opened.scenario, run);
  run["summary"] = build_summary(report);
  run["structure"] = build_structure(log.opened.scenario, log.analysis, frames.get_layout());
  run["frames"] = frames.build_json(budget);
  return run;
}

// The first difference, or why there is none to be found: recordings of two models can be seen side by side all the
// same.
Json build_difference(const std::vector<std::string>& logs) {
  try {
    std::array<OpenedLog, 2> opened{OpenedLog(logs[0]), OpenedLog(logs[1])};
    const hil::LogDiff diff = hil::diff({&opened[0].recording, &opened[1].recording},
                                        {opened[0].simulation.get(), opened[1].simulation.get()});
    return build_json(DiffReport{opened, diff});
  } catch (const hil::LogError& error) {
    return {{"refused", error.what()}};
  }
}

void refuse_to_overwrite(const ReportOptions& options) {
  for (const std::string& log : options.logs) {
    std::error_code error;
    if (std::filesystem::equivalent(log, options.out, error)) {
      refuse_option("--out", options.out + " is the recording; the report needs a file of its own");
    }
  }
}

int run(const ReportOptions& options) {
  if (!has_pages()) {
    std::fprintf(stderr, "unlatch report: %s\n", kNoPages);
    return kExitEnvironment;
  }
  refuse_to_overwrite(options);
  check_output(options.out);
  Json document = {{"format", 1}, {"program", "unlatch " UNLATCH_VERSION}, {"runs", Json::array()}};
  bool sound = true;
  for (const std::string& log : options.logs) {
    document["runs"].push_back(build_run(log, kFrameBudget / options.logs.size(), sound));
  }
  if (options.logs.size() == 2) document["diff"] = build_difference(options.logs);
  const std::string page = build_report_page(document);
  write_text(page, options.out);
  std::fprintf(stderr, "%s: %.1f MB\n", options.out.c_str(), static_cast<double>(page.size()) * 1e-6);
  for (const Json& one : document.at("runs"))
    if (one.at("status") != "ok")
      std::fprintf(stderr, "  %s: %s: %s\n", one.at("log").get<std::string>().c_str(),
                   one.at("status").get<std::string>().c_str(), one.at("message").get<std::string>().c_str());
  if (!sound)
    std::fprintf(stderr, "unlatch report: a recording does not replay as it was recorded; the page says where\n");
  return sound ? kExitDone : kExitFailed;
}

}  // namespace

void add_report(Command app, int& exit_code) {
  auto options = std::make_shared<ReportOptions>();
  Command command = app.add_verb(
      "report",
      "Replays one or two recordings and writes one HTML file that works offline: the bodies in motion, plots, the "
      "event "
      "timeline, timing, the scenario. Exit code 1: the file was written, but a replay differs from its recording.",
      "unlatch report run.log --out run.html\n"
      "unlatch report yesterday.log today.log --out both.html");
  command.add_option("LOG", options->logs, "recording made by --log; a second one is drawn over the first")
      .required()
      .expected(1, 2);
  command.add_option("--out", options->out, "file to write (.html)").required().type_name("FILE");
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
