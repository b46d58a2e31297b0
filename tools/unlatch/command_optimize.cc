// unlatch optimize: values of a scenario that are best for an objective and meet its requirements.
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "hil/run/run.h"
#include "tools/exit_codes.h"
#include "tools/interrupt.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/optimize_report.h"
#include "tools/unlatch/report.h"
#include "tools/unlatch/terminal.h"

namespace unlatch::tools {
namespace {

struct OptimizeOptions {
  std::string file, out, json;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool resume = false;
};

DesignVerification verify(const hil::DesignProblem& problem, const std::string& patch,
                          const hil::DesignSample& sample) {
  const hil::Scenario scenario = hil::load_scenario(patch);
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation, {});
  const hil::LogEnd end =
      hil::run_fast(*simulation, analysis, nullptr, calc_last_tick(scenario), catch_interrupts(), [] {});
  DesignVerification verification{end.status == hil::RunStatus::kDone, end.hash == sample.hash, end.hash};
  const std::vector<hil::Verdict> verdicts = analysis.judge();
  for (const hil::DesignConstraint& constraint : problem.constraints)
    for (const hil::Verdict& verdict : verdicts)
      if (verdict.requirement == constraint.requirement && !verdict.is_met()) verification.met = false;
  return verification;
}

// On a terminal one line that is overwritten, elsewhere a line each tenth of the budget.
void show_progress(const hil::DesignProblem& problem, const hil::DesignEvaluations* evaluations, std::int64_t& shown) {
  if (evaluations == nullptr) return;
  const std::int64_t runs = evaluations->get_runs();
  if (runs > problem.budget.runs) return;  // those around the result
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (!terminal && 10 * runs / problem.budget.runs == shown) return;
  shown = 10 * runs / problem.budget.runs;
  std::fprintf(stderr, terminal ? "\r%lld of at most %lld runs" : "%lld of at most %lld runs\n",
               static_cast<long long>(runs), static_cast<long long>(problem.budget.runs));
}

int optimize(const OptimizeOptions& options) {
  namespace fs = std::filesystem;
  check_output(options.json);
  const hil::DesignProblem problem = hil::load_design_problem(options.file);
  std::error_code error;
  const fs::path out(options.out);
  fs::create_directories(out, error);
  if (error) throw OutputError(options.out + ": " + error.message());
  const std::string journal = (out / "history.csv").string();
  if (!options.resume && fs::exists(journal))
    refuse_option("--out", options.out + " has a history.csv: give --resume to go on with it, or another folder");
  const hil::DesignEvaluations* known = nullptr;
  std::int64_t shown = 0;
  hil::DesignEvaluations evaluations(problem, {journal, options.resume, options.jobs}, catch_interrupts(),
                                     [&] { show_progress(problem, known, shown); });
  known = &evaluations;
  const hil::DesignResult result = hil::search_design(problem, evaluations);
  if (isatty(STDERR_FILENO) != 0) std::fputs("\r\033[K", stderr);

  DesignReport report{problem, evaluations, result, std::nullopt};
  if (!evaluations.get_samples().empty()) {
    const hil::DesignSample& best = evaluations.get_samples()[result.best];
    const std::string patch = (out / "patch.yaml").string();
    write_text(write_patch(problem, best.point), patch);
    if (best.status != hil::SampleStatus::kInvalid && !evaluations.was_stopped())
      report.verification = verify(problem, patch, best);
    if (!result.front.empty()) write_text(write_front(problem, evaluations, result), (out / "front.csv").string());
  }
  const nlohmann::ordered_json json = build_design_json(report);
  write_json(json, (out / "result.json").string());
  if (!options.json.empty()) write_json(json, options.json);
  print_design(get_people_stream(options.json), report);
  const bool verified = report.verification && report.verification->met && report.verification->same_bits;
  return result.feasible && verified ? kExitDone : kExitFailed;
}

}  // namespace

void add_optimize(Command app, int& exit_code) {
  auto options = std::make_shared<OptimizeOptions>();
  Command command = app.add_verb(
      "optimize",
      "Finds values of a scenario that are best for an objective and meet its requirements. Exit code 1 if none meet "
      "them.",
      "unlatch optimize hil/scenarios/boosters/synthesis.yaml --out design\nunlatch run design/patch.yaml");
  command.add_option("FILE", options->file, "problem of synthesis (.yaml)").required();
  command.add_option("--out", options->out, "folder for patch.yaml, result.json, history.csv, front.csv")
      .type_name("DIR")
      .required();
  command
      .add_option("--jobs", options->jobs,
                  "threads; the result does not depend on them (default: one for each processor)")
      .type_name("N")
      .within(1, 256);
  command.add_flag("--resume", options->resume, "goes on after an end at any moment, with the same result");
  command.add_json_option(options->json, "the same as DIR/result.json");
  command.callback([options, &exit_code] { exit_code = optimize(*options); });
}

}  // namespace unlatch::tools
