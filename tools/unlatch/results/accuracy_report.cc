#include "tools/unlatch/results/accuracy_report.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/run.h"
#include "hil/run/start_growth.h"
#include "hil/scenario/text/count.h"
#include "hil/study/evaluation/step_settings.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/program/interrupt.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

// A run of the same scenario over the same time, at another step.
struct Comparison {
  hil::Scenario scenario;
  std::unique_ptr<hil::Simulation> simulation;
  std::vector<hil::NamedValue> values;
  std::string failure;  // empty if it ended well
};

Comparison run_at(const ScenarioOptions& options, const hil::Scenario& scenario, double dt, double until) {
  ScenarioOptions other = set_step(options, scenario, dt);
  other.until = until;
  Comparison run{load(other), nullptr, {}, ""};
  run.simulation = hil::build_simulation(run.scenario);
  hil::RunAnalysis analysis(run.scenario, *run.simulation);
  const hil::LogEnd end =
      hil::run_fast(*run.simulation, analysis, nullptr, calc_last_tick(run.scenario), catch_interrupts(), [] {});
  if (end.status != hil::RunStatus::kDone) run.failure = end.message;
  run.values = hil::list_values(run.scenario, *run.simulation, analysis);
  return run;
}

constexpr double kNano = 1e9;

// The longest step up to `most` of which a whole number makes the run, in whole nanoseconds as scenarios want them; 0
// if there is none among the first kMostCounts numbers of ticks.
double find_whole_step(double most, double until) {
  constexpr std::int64_t kMostCounts = 1'000'000;  // some milliseconds
  const std::int64_t total = std::llround(until * kNano);
  const std::int64_t longest = std::llround(std::floor(most * kNano * (1 + 1e-9)));
  if (longest < 1 || total < 1) return 0;
  const std::int64_t fewest = (total + longest - 1) / longest;
  const std::int64_t last = std::min(total, fewest + std::min(fewest, kMostCounts));
  for (std::int64_t count = fewest; count <= last; ++count)
    if (total % count == 0) return static_cast<double>(total / count) / kNano;
  return 0;
}

// Progress of the comparison, on a terminal alone.
void print_progress(const char* what, double dt) {
  if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "accuracy: %s, at a step of %.9g s\n", what, dt);
}

// The largest step that meets the tolerance, tried: from the estimate down by a quarter each time. The trials together
// may cost as many steps as the three runs of the comparison, so that all of it takes at most twice their time.
void find_step(const ScenarioOptions& options, const hil::Scenario& scenario, double until,
               hil::AccuracyReport& accuracy) {
  constexpr double kMostGrowth = 16, kLongest = 1, kShortest = 1e-6, kShrink = 0.75;  // of dt; s; s
  constexpr double kComparison = 1 + 2 + 4;  // steps of the three runs, in those of the first
  constexpr int kTrials = 6;
  constexpr double kMostSteps = 1e12;  // of a run
  const double dt = scenario.dt;
  double budget = kComparison;
  auto [step, limit] = hil::estimate_step(accuracy, dt, accuracy.tolerance, std::min(kMostGrowth * dt, kLongest));
  accuracy.limit = limit;
  const double shortest = std::max(kShortest, until / kMostSteps);
  for (int trial = 0; trial < kTrials && !catch_interrupts().load(); ++trial, step *= kShrink) {
    if (!(step >= shortest)) return;  // also of an estimate that is no number
    const double whole = find_whole_step(std::min(step, until), until);
    if (whole < shortest) return;
    budget -= dt / whole;
    if (budget < 0) {
      accuracy.out_of_budget = true;
      return;
    }
    print_progress("a trial", whole);
    const Comparison run = run_at(options, scenario, whole, until);
    if (catch_interrupts()) {
      accuracy.interrupted = true;
      return;
    }
    if (!run.failure.empty() || hil::calc_largest_error(accuracy, run.values) > accuracy.tolerance) continue;
    accuracy.step = whole;
    return;
  }
}

// The scenario at the longest of some multiples of its step at which the run ends alike; nothing if there is none.
std::optional<hil::Scenario> find_coarse(const ScenarioOptions& options, const hil::Scenario& scenario,
                                         const hil::Simulation& simulation) {
  for (const int multiple : {16, 8, 4, 2}) {
    const std::int64_t ticks = simulation.get_tick();
    if (ticks % multiple != 0 || catch_interrupts()) continue;
    ScenarioOptions other = set_step(options, scenario, multiple * scenario.dt);
    other.until = simulation.get_time();
    try {
      hil::Scenario coarse = load(other);
      if (hil::ends_alike(coarse, ticks / multiple, simulation, catch_interrupts())) return coarse;
    } catch (const std::exception&) {  // a step at which the scenario has mistakes
    }
  }
  return std::nullopt;
}

}  // namespace

ScenarioOptions set_step(const ScenarioOptions& options, const hil::Scenario& scenario, double step) {
  ScenarioOptions other = options;
  other.dt = 0;
  for (const hil::Setting& setting : hil::make_step_settings(scenario, step))
    other.overrides.push_back(to_text(setting));
  return other;
}

std::string get_full_name(const hil::RunNotice& notice) { return "accuracy." + notice.name; }

hil::AccuracyReport measure_accuracy(const ScenarioOptions& options, const hil::Scenario& scenario,
                                     const hil::Simulation& simulation, const hil::RunAnalysis& analysis,
                                     double tolerance) {
  const double dt = simulation.plan().get_options().dt, until = simulation.get_time();
  if (std::llround(dt * kNano) % 4 != 0)
    refuse_option("--accuracy", "the step is halved twice, and steps are whole nanoseconds: use --dt");
  print_progress("the second of three runs", 0.5 * dt);
  hil::AccuracyReport interrupted;
  interrupted.tolerance = tolerance;
  interrupted.interrupted = true;
  const Comparison half = run_at(options, scenario, 0.5 * dt, until);
  if (catch_interrupts()) return interrupted;
  print_progress("the third of three runs", 0.25 * dt);
  const Comparison quarter = run_at(options, scenario, 0.25 * dt, until);
  if (catch_interrupts()) return interrupted;
  hil::AccuracyReport accuracy = hil::compare_steps(
      scenario, simulation, hil::list_values(scenario, simulation, analysis), half.values, quarter.values);
  if (!half.failure.empty()) accuracy.mismatch = "the run at half the step failed: " + half.failure;
  if (!quarter.failure.empty()) accuracy.mismatch = "the run at a quarter of the step failed: " + quarter.failure;
  accuracy.tolerance = tolerance;
  if (accuracy.mismatch.empty()) find_step(options, scenario, until, accuracy);
  return accuracy;
}

bool tell_unresolved(const hil::RunAnalysis& analysis, std::string& status, std::string& message) {
  const std::string failure = analysis.accuracy().describe_unresolved();
  if (failure.empty() || status != "ok") return false;
  status = kUnresolved;
  message += (message.empty() ? "" : "; ") + failure;
  return true;
}

void print_accuracy_notices(std::FILE* to, const RunReport& report) {
  const std::vector<hil::RunNotice>& notices = report.analysis.accuracy().get();
  if (notices.empty()) return;
  print_heading(to, "Not resolved by the step (first time of each, worst value)");
  for (const hil::RunNotice& notice : notices) {
    std::fprintf(to, "  %12.6f s  %s\n", notice.time,
                 paint(to, Colour::kYellow,
                       notice.name + (notice.subject.empty() ? "" : " " + notice.subject) + ": " + notice.text +
                           (notice.worst_time > notice.time ? format(" (worst at %.6f s)", notice.worst_time) : "") +
                           (notice.unresolved ? "; what depends on it is unresolved" : ""))
                     .c_str());
  }
}

void measure_growth(const ScenarioOptions& options, const hil::Scenario& scenario, const hil::Simulation& simulation,
                    hil::AccuracyReport& accuracy) {
  if (accuracy.interrupted) return;
  std::int64_t last = simulation.get_tick();
  const std::optional<hil::Scenario> coarse = find_coarse(options, scenario, simulation);
  if (coarse) last = std::llround(static_cast<double>(last) * scenario.dt / coarse->dt);
  print_progress("growth of changes of the start", coarse ? coarse->dt : scenario.dt);
  if (auto growth = hil::measure_growth(scenario, coarse ? *coarse : scenario, last, catch_interrupts())) {
    accuracy.growth = *std::move(growth);
    accuracy.growth_measured = true;
    accuracy.growth_step = coarse ? coarse->dt : scenario.dt;
  }
  accuracy.interrupted = catch_interrupts();
}

void print_energy(std::FILE* to, const hil::EnergyBalance& energy) {
  print_heading(to, "Energy, J (seen from the centre of mass)");
  // Each is a sum of terms as large as the scale, of which rounding leaves so much.
  const auto show = [&energy](double value) { return drop_rounding(value, energy.scale); };
  std::fprintf(to, "  motion gained %.6g: springs and modes gave %.6g, impulses %.6g", show(energy.kinetic),
               show(energy.strain), show(energy.impulses));
  for (std::size_t i = 0; i < energy.work.size(); ++i)
    if (energy.work[i] != 0) std::fprintf(to, ", %s %.6g", kPowerSourceNames[i], show(energy.work[i]));
  if (energy.contacts != 0) std::fprintf(to, ", contacts %.6g", show(energy.contacts));
  if (energy.numerical != 0) std::fprintf(to, ", damping of the implicit method %.3g", show(energy.numerical));
  std::fprintf(to, "\n  unexplained %.3g, at most %.3g at %.6g s; largest energy %.6g\n", energy.unexplained,
               energy.largest, energy.largest_time, energy.scale);
}

namespace {

// What a shorter step has beside it, see hil::make_step_settings().
std::string describe_refinement(double step, double dt) {
  constexpr double kRounding = 1e-9;  // of the ratio of two steps
  return step < dt ? format(" (if there are contacts, with contact_refinement %.0f)", std::ceil(dt / step - kRounding))
                   : "";
}

// One line for each reason, with the values that it concerns.
void print_reasons(std::FILE* to, const std::vector<hil::AccuracyEntry>& entries) {
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> reasons;
  std::map<std::string, std::vector<std::string>> values;
  for (const hil::AccuracyEntry& entry : entries) {
    if (entry.settles) continue;
    if (values[entry.reason].empty()) reasons.push_back(entry.reason);
    values[entry.reason].push_back(entry.value.what);
  }
  if (reasons.empty()) return;
  print_heading(to, "Not at the expected order, and the likely reason");
  for (const std::string& reason : reasons) {
    const std::vector<std::string>& names = values[reason];
    std::string text = names.front();
    for (std::size_t i = 1; i < std::min(names.size(), kNamed); ++i) text += ", " + names[i];
    if (names.size() > kNamed) text += " and " + hil::count(names.size() - kNamed, "other value");
    std::fprintf(to, "  %s: %s\n", text.c_str(), reason.c_str());
  }
}

void print_growth(std::FILE* to, const hil::AccuracyReport& accuracy) {
  if (accuracy.growth.empty()) return;
  print_heading(to, "Sensitive to the start: no step makes the end more certain than this");
  for (const hil::StartGrowth& growth : accuracy.growth) {
    using Of = hil::StartGrowth::Of;
    const char* const verb = growth.of == Of::kPlace || growth.of == Of::kVelocity ? "moves" : "turns";
    const char* const beside =
        growth.of == Of::kPlace || growth.of == Of::kAttitude ? "at the end" : "as in free motion";
    std::fprintf(to, "  an error of the %s of %s at the start %s %s %.3g times as far %s\n", hil::get_name(growth.of),
                 growth.start.c_str(), verb, growth.end.c_str(), growth.factor, beside);
  }
}

}  // namespace

void print_accuracy(std::FILE* to, const hil::AccuracyReport& accuracy, double dt) {
  std::fprintf(
      to, "\n%s\n",
      paint(to, Colour::kBold, "Accuracy: errors at the scenario's step, from runs at its half and its quarter")
          .c_str());
  std::fprintf(to, "  %-58s %18s %10s %6s\n", "what", "value", "error", "order");
  for (const hil::AccuracyEntry& entry : accuracy.entries) {
    char order[16] = "–";
    if (entry.order) std::snprintf(order, sizeof order, "%.1f", *entry.order);
    std::fprintf(to, "  %-58s %18.12g %10.2g %6s %s\n", entry.value.what.c_str(),
                 drop_rounding(entry.value.value, entry.value.size), entry.error, order, entry.value.unit.c_str());
  }
  print_reasons(to, accuracy.entries);
  print_growth(to, accuracy);
  if (accuracy.interrupted) {
    std::fprintf(to, "\n  %s\n", paint(to, Colour::kRed, "interrupted: the comparison is not complete").c_str());
    return;
  }
  if (!accuracy.mismatch.empty()) {
    std::fprintf(to, "\n  %s\n", paint(to, Colour::kRed, "the runs differ: " + accuracy.mismatch).c_str());
  } else if (accuracy.step) {
    std::fprintf(to, "\n  largest step that meets %.3g of each value's size: %.6g s%s (here %.6g s)%s%s\n",
                 accuracy.tolerance, *accuracy.step, describe_refinement(*accuracy.step, dt).c_str(), dt,
                 accuracy.limit.empty() ? "" : ", limited by ", accuracy.limit.c_str());
  } else {
    std::fprintf(to, "\n  no step was found that meets %.3g of each value's size; %s does not%s\n", accuracy.tolerance,
                 accuracy.limit.c_str(),
                 accuracy.out_of_budget
                     ? " (the search may cost as much as the three runs: raise the tolerance, or shorten the step)"
                     : "");
  }
}

Json build_energy_json(const hil::EnergyBalance& energy) {
  Json work = Json::object();
  for (std::size_t i = 0; i < energy.work.size(); ++i) work[kPowerSourceNames[i]] = energy.work[i];
  return {{"gained", energy.kinetic},           {"work", work},
          {"springs_and_modes", energy.strain}, {"impulses", energy.impulses},
          {"contacts", energy.contacts},        {"implicit_damping", energy.numerical},
          {"unexplained", energy.unexplained},  {"largest_unexplained", energy.largest},
          {"t", energy.largest_time},           {"scale", energy.scale}};
}

Json build_accuracy_json(const hil::AccuracyReport& accuracy) {
  Json entries = Json::array();
  for (const hil::AccuracyEntry& entry : accuracy.entries) {
    Json item = {{"what", entry.value.what}, {"value", entry.value.value}, {"error", entry.error}};
    item["order"] = entry.order ? Json(*entry.order) : Json(nullptr);
    item["unit"] = entry.value.unit;
    item["settles"] = entry.settles;
    if (!entry.settles) item["reason"] = entry.reason;
    item["half"] = entry.half;
    item["quarter"] = entry.quarter;
    entries.push_back(item);
  }
  return entries;
}

Json build_step_json(const hil::AccuracyReport& accuracy) {
  Json json = {{"tolerance", accuracy.tolerance},
               {"largest_step", accuracy.step ? Json(*accuracy.step) : Json(nullptr)},
               {"limited_by", accuracy.limit}};
  if (accuracy.growth_measured) {
    json["growth_step"] = accuracy.growth_step;
    json["growth"] = Json::array();
    for (const hil::StartGrowth& growth : accuracy.growth)
      json["growth"].push_back(
          {{"start", growth.start}, {"of", hil::get_name(growth.of)}, {"end", growth.end}, {"factor", growth.factor}});
  }
  if (!accuracy.mismatch.empty()) json["mismatch"] = accuracy.mismatch;
  if (accuracy.interrupted) json["interrupted"] = true;
  if (accuracy.out_of_budget) json["out_of_budget"] = true;
  return json;
}

}  // namespace unlatch::tools
