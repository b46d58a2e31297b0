// unlatch optimize: values of a scenario that are best for an objective and meet its requirements.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "hil/run/run.h"
#include "hil/study/optimize/problem/problem_step.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/optimize/page.h"
#include "tools/pages/pages.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/unlatch/options/campaign_sample.h"
#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/studies/optimize_report.h"
#include "tools/unlatch/studies/verbs.h"

namespace unlatch::tools {
namespace {

struct OptimizeOptions {
  std::string file, out, json;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool resume = false;
};

OptimizeVerification verify(const hil::OptimizeProblem& problem, const std::string& patch,
                            const hil::OptimizeSample& sample) {
  const hil::Scenario scenario = hil::load_scenario(patch);
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  const hil::LogEnd end =
      hil::run_fast(*simulation, analysis, nullptr, calc_last_tick(scenario), catch_interrupts(), [] {});
  if (end.status == hil::RunStatus::kAborted) return {OptimizeVerification::End::kInterrupted};
  OptimizeVerification verification{OptimizeVerification::End::kDone, end.status == hil::RunStatus::kDone,
                                    end.hash == sample.hash, end.hash};
  const std::vector<hil::Verdict> verdicts = analysis.judge();
  for (const hil::OptimizeConstraint& constraint : problem.constraints)
    for (const hil::Verdict& verdict : verdicts)
      if (!(constraint.probability > 0) && verdict.requirement == constraint.requirement && !verdict.is_met())
        verification.met = false;
  return verification;
}

// Finds the step of a problem with a tolerance, and writes what was found. False: there is none.
bool find_optimize_step(hil::OptimizeProblem& problem, int jobs) {
  if (!(problem.tolerance > 0)) return true;
  const bool found = choose_step(problem, jobs, catch_interrupts());
  print_step_search(stderr, *problem.step_search, catch_interrupts());
  return found;
}

// All that decides the samples, in full, and its fingerprint, by which --resume knows the problem.
nlohmann::ordered_json build_manifest(const hil::OptimizeProblem& problem) {
  nlohmann::ordered_json manifest{{"schema", 1},
                                  {"problem", problem.name},
                                  {"program", "unlatch " UNLATCH_VERSION},
                                  {"fingerprint", to_hex(static_cast<std::int64_t>(calc_fingerprint(problem)))},
                                  {"problem_text", problem.text},
                                  {"scenario_text", problem.tree->get_nominal().text},
                                  {"overrides", problem.overrides}};
  if (problem.campaign) manifest["campaign_text"] = problem.campaign->text;
  return manifest;
}

// Names the part of the problem that differs from that of the folder.
std::string describe_difference(const nlohmann::ordered_json& had, const nlohmann::ordered_json& has) {
  const std::pair<const char*, const char*> parts[] = {{"program", "version of unlatch"},
                                                       {"problem_text", "problem"},
                                                       {"overrides", "values in `set`"},
                                                       {"scenario_text", "scenario"},
                                                       {"campaign_text", "campaign"}};
  for (const auto& [key, name] : parts)
    if (had.value(key, nlohmann::ordered_json()) != has.value(key, nlohmann::ordered_json())) return name;
  return "file that the scenario names";
}

// The journal of an earlier search, if it is this problem's. Without one the folder gets this problem's manifest.
void open_folder(const OptimizeOptions& options, const hil::OptimizeProblem& problem) {
  namespace fs = std::filesystem;
  const fs::path out(options.out), manifest = out / "manifest.json", journal = out / "history.csv";
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw OutputError(options.out + ": " + error.message());
  const nlohmann::ordered_json now = build_manifest(problem);
  if (fs::exists(journal)) {
    if (!options.resume)
      refuse_option("--out", options.out + " has a history.csv: give --resume to go on with it, or another folder");
    std::ifstream file(manifest);
    const auto had = nlohmann::ordered_json::parse(file, nullptr, false);
    if (!had.is_object())
      refuse_option("--resume", manifest.string() + " is missing or damaged; choose another folder");
    if (had.value("fingerprint", "") != now.at("fingerprint").get<std::string>())
      refuse_option("--resume", options.out + " is of another problem: its " + describe_difference(had, now) +
                                    " differs; choose another folder");
  } else {
    write_text(now.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n", manifest.string());
  }
}

// Runs, the best so far, and time left at most: on a terminal one line that is overwritten, elsewhere a line each
// tenth of the budget.
class OptimizeProgress {
 public:
  explicit OptimizeProgress(const hil::OptimizeProblem& problem) : problem_(problem) {}

  void show(const hil::OptimizeEvaluations& evaluations) {
    const std::vector<hil::OptimizeSample>& samples = evaluations.get_samples();
    if (!merit_) merit_.emplace(problem_, &samples.front());
    for (; seen_ < samples.size(); ++seen_)  // designs are compared by the same samples
      if (samples[seen_].demand != samples[best_].demand || merit_->is_better(samples[seen_], samples[best_]))
        best_ = seen_;
    const auto runs = static_cast<std::int64_t>(samples.size());
    const std::int64_t tenth = 10 * runs / problem_.budget.runs;
    if (!terminal_ && tenth == shown_) return;
    shown_ = tenth;
    const double violation = merit_->calc_violation(samples[best_]).size;
    const std::string best =
        violation > 0 ? format("least violation %.3g of its limit", violation)
                      : format("best %.6g %s", samples[best_].objectives[0], problem_.objectives[0].unit.c_str());
    const double spent = std::chrono::duration<double>(Clock::now() - begin_).count();
    const auto made = static_cast<double>(std::max<std::int64_t>(1, runs - evaluations.get_taken()));
    double left = spent / made * static_cast<double>(problem_.budget.runs - runs);
    if (problem_.budget.seconds > 0) left = std::min(left, std::max(0.0, problem_.budget.seconds - spent));
    const std::int64_t flights = samples[best_].demand.flights;
    const std::string each = flights > 0 ? " of " + count(flights, "sample") : "";
    std::fprintf(stderr, "%s%lld of at most %s%s, %s (run %zu), at most %.0f s left%s", terminal_ ? "\r\033[K" : "",
                 static_cast<long long>(runs), count(std::max(runs, problem_.budget.runs), "run").c_str(), each.c_str(),
                 best.c_str(), best_ + 1, std::max(0.0, left), terminal_ ? "" : "\n");
    std::fflush(stderr);
  }
  void clear() const {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  const hil::OptimizeProblem& problem_;
  std::optional<hil::OptimizeMerit> merit_;
  const bool terminal_ = is_terminal(stderr);
  const Clock::time_point begin_ = Clock::now();
  std::size_t seen_ = 0, best_ = 0;
  std::int64_t shown_ = 0;
};

int optimize(const OptimizeOptions& options) {
  namespace fs = std::filesystem;
  check_output(options.json);
  hil::OptimizeProblem loaded = hil::load_optimize_problem(options.file);
  if (!find_optimize_step(loaded, options.jobs)) return kExitFailed;
  const hil::OptimizeProblem problem = std::move(loaded);
  const fs::path out(options.out);
  const std::string journal = (out / "history.csv").string();
  open_folder(options, problem);
  const hil::OptimizeEvaluations* known = nullptr;
  OptimizeProgress progress(problem);
  hil::OptimizeEvaluations evaluations(problem, {journal, options.resume, options.jobs}, catch_interrupts(),
                                       [&] { progress.show(*known); });
  known = &evaluations;
  const std::string patch = (out / "patch.yaml").string();
  const hil::OptimizeResult result =
      hil::search_optimum(problem, evaluations, true, [&](const hil::OptimizePoint& found) {
        if (!evaluations.was_stopped()) write_text(write_patch(problem, found), patch);
      });
  progress.clear();

  OptimizeReport report{problem, evaluations, result, {}, {}};
  std::string patch_text;
  if (!evaluations.get_samples().empty()) {
    const hil::OptimizeSample& best = evaluations.get_samples()[result.best];
    report.limits = calc_limits(problem, best.point);
    patch_text = write_patch(problem, best.point);
    write_text(patch_text, patch);
    if (evaluations.was_stopped())
      report.verification.end = OptimizeVerification::End::kInterrupted;
    else if (best.status != hil::SampleStatus::kInvalid)
      report.verification = verify(problem, patch, best);
    if (problem.tolerance > 0 && report.verification.end == OptimizeVerification::End::kDone)
      report.verification.step_error = calc_step_error(problem, best.point, catch_interrupts());
    if (!result.front.empty()) write_text(write_front(report), (out / "front.csv").string());
  }
  const nlohmann::ordered_json json = build_optimize_json(report);
  write_json(json, (out / "result.json").string());
  if (!options.json.empty()) write_json(json, options.json);
  if (!has_pages()) {
    std::fprintf(stderr, "note: no report.html: %s\n", kNoPages);
  } else if (!evaluations.get_samples().empty()) {
    const hil::OptimizePoint& best = evaluations.get_samples()[result.best].point;
    write_text(build_optimize_page({problem, evaluations, result, json, build_manifest(problem), patch_text,
                                    fly_point(problem, get_start(problem), catch_interrupts()),
                                    fly_point(problem, best, catch_interrupts())}),
               (out / "report.html").string());
  }
  print_optimize_report(get_people_stream(options.json), report);
  return is_verified(report) ? kExitDone : kExitFailed;
}

}  // namespace

void add_optimize(Command app, int& exit_code) {
  auto options = std::make_shared<OptimizeOptions>();
  Command command = app.add_verb(
      "optimize",
      "Finds values of a scenario that are best for an objective and meet its requirements. Exit code 1 if none meet "
      "them, or the verification refutes the result.",
      "unlatch optimize hil/scenarios/boosters/synthesis.yaml --out design\nunlatch run design/patch.yaml");
  command.add_option("FILE", options->file, "optimisation problem (.yaml)").required();
  command.add_option("--out", options->out, "folder for patch.yaml, report.html, result.json, history.csv, front.csv")
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
