// unlatch run: without flight software, as fast as it goes, in one process.
#include <atomic>
#include <charconv>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "hil/run/checkpoint.h"
#include "hil/run/run.h"
#include "hil/scenario/text/number_text.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/unlatch/options/campaign_sample.h"
#include "tools/unlatch/options/output_options.h"
#include "tools/unlatch/options/scenario_notes.h"
#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/results/accuracy_report.h"
#include "tools/unlatch/results/report.h"
#include "tools/unlatch/results/verdict_report.h"
#include "tools/unlatch/run/recording_watch.h"
#include "tools/unlatch/run/verbs.h"

namespace unlatch::tools {
namespace {

// Values of --accuracy.
constexpr const char* kNotAsked = "no";
constexpr double kUsualTolerance = 1e-6;

struct RunOptions {
  ScenarioOptions scenario;
  std::vector<double> samples;                              // s
  std::vector<std::pair<double, std::string>> checkpoints;  // s, file
  std::string resume;                                       // file
  std::string results;                                      // folder of a campaign
  std::string outputs;                                      // patterns; empty: the scenario's
  std::string accuracy = kNotAsked;                         // tolerance, or empty for the usual one
  std::string tolerance = kNotAsked;                        // of which the step is found
  OutputOptions output;
};

double read_tolerance(const char* option, const std::string& text) {
  if (text.empty() || text == "true") return kUsualTolerance;
  double tolerance = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), tolerance);
  if (error != std::errc() || end != text.data() + text.size() || !(tolerance > 0 && tolerance < 1))
    refuse_option(option, "'" + text + "' is no tolerance: a number above 0 and below 1, of each value's size");
  return tolerance;
}

// The ticks of this run: where it begins, where it ends.
struct Span {
  double dt;  // s
  std::int64_t first, last;
};

// Samples and checkpoints are taken at ticks; a time between two is moved, and that is said.
std::int64_t calc_tick_within(const char* option, const char* what, double time, const Span& span) {
  const std::int64_t tick = hil::calc_nearest_tick(time, span.dt);
  if (!(tick >= span.first && tick <= span.last)) {
    refuse_option(option, hil::write_number(time) + " s is not within the run");
  }
  constexpr double kSameTime = 1e-9;  // of a step: the rounding of T / dt
  if (std::abs(static_cast<double>(tick) - time / span.dt) > kSameTime * std::max(1.0, time / span.dt)) {
    std::fprintf(stderr, "note: %.9g s is not on a tick; the %s is taken at %.9g s\n", time, what,
                 static_cast<double>(tick) * span.dt);
  }
  return tick;
}

std::vector<std::int64_t> calc_sample_ticks(const RunOptions& options, const Span& span) {
  std::vector<std::int64_t> ticks;
  for (const double time : options.samples) ticks.push_back(calc_tick_within("--sample", "sample", time, span));
  if (ticks.empty()) ticks.push_back(span.last);
  return ticks;
}

// Writes each checkpoint when the run comes to its tick.
class Checkpoints {
 public:
  Checkpoints(const RunOptions& options, const hil::Scenario& scenario, const hil::Simulation& simulation,
              const hil::RunAnalysis& analysis, const Span& span)
      : scenario_(scenario), simulation_(simulation), analysis_(analysis), last_tick_(span.last) {
    for (const auto& [time, path] : options.checkpoints) {
      due_.emplace(calc_tick_within("--checkpoint", "checkpoint", time, span), path);
    }
  }

  void look() {
    for (; !due_.empty() && due_.begin()->first == simulation_.get_tick(); due_.erase(due_.begin())) {
      hil::write_checkpoint(due_.begin()->second, scenario_, simulation_, last_tick_,
                            !analysis_.accuracy().describe_unresolved().empty());
    }
  }

 private:
  const hil::Scenario& scenario_;
  const hil::Simulation& simulation_;
  const hil::RunAnalysis& analysis_;
  const std::int64_t last_tick_;
  std::multimap<std::int64_t, std::string> due_;
};

hil::LogEnd run_with_progress(hil::Simulation& simulation, hil::RunAnalysis& analysis, hil::Recorder* recorder,
                              Checkpoints& checkpoints, hil::RunOutputs& outputs, std::int64_t last_tick) {
  std::atomic<std::int64_t> tick{simulation.get_tick()};
  Progress progress(simulation.plan().get_options().dt, last_tick);
  std::mutex mutex;
  std::condition_variable_any stopped;  // ends the wait for the next look at once
  std::jthread watcher([&](const std::stop_token& stopping) {
    RecordingWatch recording(recorder);
    std::unique_lock lock(mutex);
    while (!stopping.stop_requested()) {
      recording.look(progress);
      progress.show(tick.load(std::memory_order_relaxed));
      stopped.wait_for(lock, stopping, std::chrono::milliseconds(20), [] { return false; });
    }
  });
  hil::LogEnd end = hil::run_fast(simulation, analysis, recorder, last_tick, catch_interrupts(), [&] {
    checkpoints.look();
    outputs.look();
    tick.store(simulation.get_tick(), std::memory_order_relaxed);
  });
  watcher.request_stop();
  watcher.join();
  progress.clear();
  return end;
}

// A campaign file is run as one of its samples: --sample is the sample's number then.
RunOptions resolve_sample(RunOptions options) {
  if (!is_campaign(options.scenario)) {
    if (!options.results.empty()) refuse_option("--results", "it belongs to a campaign file and --sample");
    return options;
  }
  if (options.samples.size() != 1 || options.samples[0] != std::floor(options.samples[0]))
    refuse_option("--sample", "of a campaign one sample is run: --sample I, its number from 0");
  choose_sample(options.scenario, static_cast<std::int64_t>(options.samples[0]), options.results);
  options.samples.clear();
  return options;
}

// Finds the largest step that meets --tolerance, and makes it that of the run.
hil::AccuracyReport choose_step(RunOptions& options) {
  const double tolerance = read_tolerance("--tolerance", options.tolerance);
  const hil::Scenario scenario = load(options.scenario);
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  const hil::LogEnd end =
      hil::run_fast(*simulation, analysis, nullptr, calc_last_tick(scenario), catch_interrupts(), [] {});
  hil::AccuracyReport accuracy;
  accuracy.tolerance = tolerance;
  accuracy.interrupted = catch_interrupts();
  if (end.status != hil::RunStatus::kDone) return accuracy;
  accuracy = measure_accuracy(options.scenario, scenario, *simulation, analysis, tolerance);
  if (accuracy.step) {
    options.scenario = set_step(options.scenario, scenario, *accuracy.step);
    std::fprintf(stderr, "tolerance %g: the step is %.9g s, the scenario's %.9g s\n", tolerance, *accuracy.step,
                 scenario.dt);
  } else {
    std::fprintf(stderr, "tolerance %g: no step was found that meets it; the run is at %.9g s\n", tolerance,
                 scenario.dt);
  }
  return accuracy;
}

// Options that need runs from the start.
void check_step_options(const RunOptions& options) {
  const bool compares = options.accuracy != kNotAsked, chooses = options.tolerance != kNotAsked;
  if (compares) (void)read_tolerance("--accuracy", options.accuracy);
  if (compares && chooses)
    refuse_option("--tolerance", "it has the table of --accuracy already; leave one of them out");
  if ((compares || chooses) && !options.resume.empty())
    refuse_option(compares ? "--accuracy" : "--tolerance",
                  "a checkpoint is of one step; runs at its half and its quarter begin at the start");
}

int run(const RunOptions& given) {
  RunOptions options = resolve_sample(given);
  const bool compares = options.accuracy != kNotAsked, chooses = options.tolerance != kNotAsked;
  check_step_options(options);
  check_output(options.output.json);
  check_output(options.output.junit);
  for (const auto& [time, path] : options.checkpoints) check_output(path);
  std::optional<hil::AccuracyReport> chosen;
  const WallTime wall_time;
  if (chooses) chosen = choose_step(options);
  const hil::Scenario scenario = load(options.scenario);
  const std::int64_t last_tick = calc_last_tick(scenario);
  warn_of_unstable_elements(scenario);
  warn_of_absent_flight_software(scenario);
  const auto simulated = hil::build_simulation(scenario);
  hil::Simulation& simulation = *simulated;
  if (!options.resume.empty()) hil::read_checkpoint(options.resume, scenario, simulation);
  const Span span{scenario.dt, simulation.get_tick(), last_tick};
  if (span.first > span.last) {
    refuse_option("--resume", options.resume + ": is of a time after the end of this run");
  }
  hil::RunAnalysis analysis(scenario, simulation);
  hil::RunOutputs outputs(scenario, simulation, calc_sample_ticks(options, span),
                          choose_outputs(scenario, options.outputs));
  Checkpoints checkpoints(options, scenario, simulation, analysis, span);

  std::optional<hil::Recorder> recorder;
  if (!options.output.log.empty()) {
    recorder.emplace(options.output.log, hil::build_log_header(scenario, simulation, hil::Pace::kFast, 0, last_tick));
  }
  hil::LogEnd end =
      run_with_progress(simulation, analysis, recorder ? &*recorder : nullptr, checkpoints, outputs, last_tick);
  outputs.finish();
  if (recorder) recorder->close(end);

  RunReport report{scenario,   simulation, analysis,    get_status_name(end.status), end.message, end.tick, end.hash,
                   end.timing, {},         std::nullopt};
  report.outputs = &outputs;
  if (chosen) report.accuracy = std::move(chosen);
  if (compares && end.status == hil::RunStatus::kDone) {
    report.accuracy = measure_accuracy(options.scenario, scenario, simulation, analysis,
                                       read_tolerance("--accuracy", options.accuracy));
    measure_growth(options.scenario, scenario, simulation, *report.accuracy);
  }
  bool unresolved = tell_unresolved(analysis, report.status, report.message);
  if (chooses && !unresolved && report.status == "ok" && !report.accuracy->step) {
    unresolved = true;
    report.status = "unresolved";
    report.message = "no step was found that meets the tolerance";
  }
  print_report(get_people_stream(options.output.json), report);
  write_json(report, options.output.json);
  write_junit(report, options.output.junit, wall_time.get());
  if (recorder && !recorder->get_error().empty()) throw OutputError(recorder->get_error());
  const bool is_interrupted = report.accuracy && report.accuracy->interrupted;
  return end.status == hil::RunStatus::kDone && !unresolved && !is_interrupted && is_met(report) ? kExitDone
                                                                                                 : kExitFailed;
}

}  // namespace

void add_run(Command app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  Command command = app.add_verb(
      "run", "Runs a scenario without flight software, as fast as possible. Exit code 1 if a requirement is not met.",
      "unlatch run hil/scenarios/boosters/reference.yaml --sample 0,2 --json result.json\n"
      "unlatch run hil/scenarios/boosters/reference.yaml --set bodies.core.mass=99000 --log run.log");
  add_scenario_options(command, options->scenario);
  command
      .add_option("--sample", options->samples,
                  "times at which the JSON has all bodies and reactions, s (default: the end); of a campaign file the "
                  "number of the sample to run, from 0")
      .delimiter(',')
      .type_name("SECONDS,...")
      .seconds(Seconds::kZeroToo);
  command
      .add_option("--results", options->results,
                  "of a campaign: the folder of its results, from which the sample's values are taken; subset sampling "
                  "needs it after its first level")
      .type_name("DIR");
  command.add_option("--checkpoint", options->checkpoints, "saves the state at a time, s, for --resume; repeatable")
      .type_name("SECONDS FILE")
      .seconds(Seconds::kZeroToo, 0);
  command
      .add_option("--resume", options->resume,
                  "continues from a checkpoint of the same scenario, with the same bits; results start there")
      .type_name("FILE");
  command
      .add_option(
          "--accuracy", options->accuracy,
          "runs at dt, dt/2 and dt/4 and estimates the error of every result, and the largest step at which all "
          "errors are within a tolerance, relative to each value's size (default: 1e-6)")
      .type_name("TOLERANCE")
      .expected(0, 1);
  command
      .add_option("--tolerance", options->tolerance,
                  "finds the largest step at which all errors are within this, relative to each value's size, as "
                  "--accuracy does, and runs at it; exit code 1 if there is none")
      .type_name("TOLERANCE");
  add_output_options(command, options->output);
  add_outputs_option(command, options->outputs);
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
