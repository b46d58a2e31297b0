#include "hil/study/evaluation/step_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hil/study/evaluation/side_by_side.h"
#include "hil/study/evaluation/step_settings.h"

namespace unlatch::hil {
namespace {

constexpr double kNano = 1e9;
constexpr double kRoom = 0.5;             // of the tolerance: the flights keep to it
constexpr std::int64_t kMostGrowth = 64;  // of the scenario's step
constexpr int kMostHalvings = 5;
constexpr int kMostMissed = 3;  // larger steps in a row that miss the tolerance: none beyond them is tried

double get_seconds(std::int64_t nanoseconds) { return static_cast<double>(nanoseconds) / kNano; }

// Every point of a curve must stay on a tick.
bool keeps_curves(const ChosenOutputs& chosen, double dt, std::int64_t growth) {
  return std::ranges::all_of(chosen.curves,
                             [&](const ChosenCurves& group) { return std::llround(group.every / dt) % growth == 0; });
}

class Search {
 public:
  Search(const SampleEvaluator& evaluator, const JudgedValues& judged, std::span<const StepFlight> flights,
         double tolerance, int jobs, const std::atomic<bool>& stop)
      : evaluator_(evaluator), judged_(judged), flights_(flights), jobs_(jobs), stop_(stop) {
    found_.tolerance = tolerance;
    found_.given = evaluator.tree().get_nominal().dt;
    found_.flights = flights.size();
  }

  StepSearch find() {
    const std::int64_t given = std::llround(found_.given * kNano);
    if (given % 2 != 0 || flights_.empty()) return found_;
    const Results at_given = fly(given), at_half = fly(given / 2);
    if (stop_) return found_;
    const StepTrial base = compare(given, at_given, at_half, 0);
    note(base, base.error);
    if (is_met())
      grow(given, at_half, base.error);
    else
      shrink(given / 2, at_half);
    if (stop_) found_.step.reset();
    return found_;
  }

 private:
  using Results = std::vector<SampleResult>;

  // All flights at a step; those that met the tolerance at a larger one are left out of the smaller ones.
  Results fly(std::int64_t nanoseconds) {
    Results results(flights_.size());
    const std::vector<Setting> step = make_step_settings(evaluator_.tree().get_nominal(), get_seconds(nanoseconds));
    run_shares_side_by_side(flights_.size(), SampleEvaluator::kSideBySide, jobs_, stop_,
                            [&](std::size_t first, std::size_t count) {
                              std::vector<SampleTask> tasks;
                              for (const StepFlight& flight : flights_.subspan(first, count)) {
                                tasks.push_back({flight.settings});
                                tasks.back().settings.insert(tasks.back().settings.end(), step.begin(), step.end());
                              }
                              std::vector<SampleResult> flown = evaluator_.evaluate(tasks, stop_);
                              std::ranges::move(flown, results.begin() + static_cast<std::ptrdiff_t>(first));
                            });
    return results;
  }

  // The worst flight at a step, with what the reference itself may be off.
  StepTrial compare(std::int64_t nanoseconds, const Results& coarse, const Results& fine, double reference) const {
    StepTrial worst{get_seconds(nanoseconds), reference, false, "", ""};
    for (std::size_t i = 0; i < flights_.size(); ++i) {
      const JudgedValues::Difference difference = judged_.compare(coarse[i], fine[i]);
      if (difference.size + reference > worst.error)
        worst = {worst.step, difference.size + reference, false, difference.of, flights_[i].name};
    }
    return worst;
  }

  void note(StepTrial trial, double more) {
    trial.error += more;
    trial.met = trial.error <= kRoom * found_.tolerance;
    if (trial.met && (!found_.step || trial.step > *found_.step)) found_.step = trial.step;
    found_.trials.push_back(std::move(trial));
  }
  [[nodiscard]] bool is_met() const { return found_.step.has_value(); }

  void grow(std::int64_t given, const Results& reference, double error) {
    const Scenario& scenario = evaluator_.tree().get_nominal();
    const std::int64_t ticks = calc_nearest_tick(scenario.until, scenario.dt);
    int missed = 0;
    for (std::int64_t growth = 2; growth <= kMostGrowth && missed < kMostMissed && !stop_; ++growth) {
      if (ticks % growth != 0 || !keeps_curves(evaluator_.chosen(), scenario.dt, growth)) continue;
      const Results flown = fly(given * growth);
      if (stop_) return;
      const auto is_invalid = [](const SampleResult& result) { return result.status == SampleStatus::kInvalid; };
      if (std::ranges::any_of(flown, is_invalid)) continue;  // such as a rate that this step does not divide
      const StepTrial trial = compare(given * growth, flown, reference, error);
      note(trial, 0);
      missed = found_.trials.back().met ? 0 : missed + 1;
    }
  }

  void shrink(std::int64_t step, Results coarse) {
    for (int halving = 0; halving < kMostHalvings && step % 2 == 0 && !is_met() && !stop_; ++halving, step /= 2) {
      Results fine = fly(step / 2);
      if (stop_) return;
      const StepTrial trial = compare(step, coarse, fine, 0);
      note(trial, trial.error);
      coarse = std::move(fine);
    }
  }

  const SampleEvaluator& evaluator_;
  const JudgedValues& judged_;
  const std::span<const StepFlight> flights_;
  const int jobs_;
  const std::atomic<bool>& stop_;
  StepSearch found_;
};

}  // namespace

Setting make_step_setting(double step) { return make_setting("step.dt", step, "s"); }

std::optional<double> halve_step(double step) {
  const std::int64_t nanoseconds = std::llround(step * kNano);
  if (nanoseconds % 2 != 0) return std::nullopt;
  return get_seconds(nanoseconds / 2);
}

StepSearch find_step(const SampleEvaluator& evaluator, const JudgedValues& judged, std::span<const StepFlight> flights,
                     double tolerance, int jobs, const std::atomic<bool>& stop) {
  return Search(evaluator, judged, flights, tolerance, jobs, stop).find();
}

std::optional<double> find_common_step(const StepSearch& a, const StepSearch& b) {
  std::optional<double> largest;
  for (const StepTrial& trial : a.trials)
    for (const StepTrial& other : b.trials)
      if (trial.met && other.met && trial.step == other.step && (!largest || trial.step > *largest))
        largest = trial.step;
  return largest;
}

std::string describe_failure(const StepSearch& search) {
  if (search.trials.empty()) return "the scenario's step is no even number of nanoseconds, and cannot be halved";
  const StepTrial& least = *std::ranges::min_element(search.trials, {}, &StepTrial::step);
  return "down to a step of " + to_text(least.step) + " s none meets it: there " + least.of + " of " + least.flight +
         " is off by " + to_text(least.error);
}

}  // namespace unlatch::hil
