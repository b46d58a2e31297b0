// unlatch run: without flight software, as fast as it goes, in one process.
#include <atomic>
#include <cmath>
#include <optional>
#include <thread>

#include "hil/run.h"
#include "tools/exit_codes.h"
#include "tools/interrupt.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/report.h"
#include "tools/unlatch/terminal.h"

namespace unlatch::tools {
namespace {

struct RunOptions {
  ScenarioOptions scenario;
  std::vector<double> samples;  // s
  OutputOptions output;
};

// Samples are taken at ticks; a time between two is moved, and that is said.
std::vector<std::int64_t> calc_sample_ticks(const RunOptions& options, double dt, std::int64_t last_tick) {
  std::vector<std::int64_t> ticks;
  for (const double time : options.samples) {
    const std::int64_t tick = hil::calc_nearest_tick(time, dt);
    if (tick < 0 || tick > last_tick) {
      throw CLI::ValidationError("--sample", std::to_string(time) + " s is not within the run");
    }
    constexpr double kSameTime = 1e-9;  // of a step: the rounding of T / dt
    if (std::abs(static_cast<double>(tick) - time / dt) > kSameTime * std::max(1.0, time / dt)) {
      std::fprintf(stderr, "note: %.9g s is not on a tick; the sample is taken at %.9g s\n", time,
                   static_cast<double>(tick) * dt);
    }
    ticks.push_back(tick);
  }
  if (ticks.empty()) ticks.push_back(last_tick);
  return ticks;
}

hil::LogEnd run_with_progress(hil::Simulation& simulation, hil::RunAnalysis& analysis, hil::Recorder* recorder,
                              std::int64_t last_tick) {
  std::atomic<std::int64_t> tick{0};
  Progress progress(simulation.plan().options.dt, last_tick);
  std::jthread watcher([&](const std::stop_token& stopping) {
    while (!stopping.stop_requested()) {
      progress.show(tick.load(std::memory_order_relaxed));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  hil::LogEnd end = hil::run_fast(simulation, analysis, recorder, last_tick, catch_interrupts(), tick);
  watcher.request_stop();
  watcher.join();
  progress.clear();
  return end;
}

int run(const RunOptions& options) {
  const hil::Scenario scenario = load(options.scenario);
  const std::int64_t last_tick = calc_last_tick(scenario);
  warn_of_unstable_elements(scenario);
  const auto simulated = hil::build_simulation(scenario);
  hil::Simulation& simulation = *simulated;
  hil::RunAnalysis analysis(scenario, simulation, calc_sample_ticks(options, scenario.dt, last_tick));

  std::optional<hil::Recorder> recorder;
  if (!options.output.log.empty()) {
    recorder.emplace(options.output.log, hil::build_log_header(scenario, simulation, hil::Pace::kFast, 0, last_tick));
  }
  hil::LogEnd end = run_with_progress(simulation, analysis, recorder ? &*recorder : nullptr, last_tick);
  if (recorder) {
    recorder->close(end);
    if (!recorder->get_error().empty()) throw OutputError(recorder->get_error());
  }

  const RunReport report{scenario,    simulation,  analysis, get_status_name(end.status),
                         end.message, end.tick,    end.hash, end.timing,
                         {},          std::nullopt};
  print_report(get_people_stream(options.output.json), report);
  write_json(build_json(report), options.output.json);
  return end.status == hil::RunStatus::kDone ? kExitDone : kExitFailed;
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      app.add_subcommand("run",
                         "Runs a scenario without flight software, as fast as it goes.\n"
                         "Example: unlatch run hil/scenarios/boosters/reference.yaml --sample 0,2 --json result.json");
  add_scenario_options(*command, options->scenario);
  command
      ->add_option("--sample", options->samples,
                   "times at which the JSON has all bodies and reactions, s (default: the end)")
      ->delimiter(',');
  add_output_options(*command, options->output);
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
