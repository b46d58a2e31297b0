#include "hil/study/evaluation/evaluation.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>

#include "hil/run/run.h"

namespace unlatch::hil {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Sensors whose values are results, by their numbers in the model: of requirements and of chosen outputs.
std::vector<int> list_read_sensors(const Scenario& scenario, const std::optional<OutputTracker>& chosen) {
  std::vector<int> sensors = chosen ? chosen->list_sensors() : std::vector<int>{};
  for (const Requirement& requirement : scenario.requirements)
    if (requirement.quantity == Requirement::Measure::kSensor) sensors.push_back(requirement.a);
  return sensors;
}

}  // namespace

const std::vector<std::string> kSampleStatusNames{"done", "faulted", "invalid", "unresolved", "interrupted"};

SampleEvaluator::SampleEvaluator(const ScenarioTree& tree, ChosenOutputs chosen)
    : tree_(tree),
      chosen_(std::move(chosen)),
      own_columns_(list_columns(tree.get_nominal())),
      columns_(list_columns(tree.get_nominal(), chosen_)),
      request_(list_needs(own_columns_)) {}

std::optional<std::size_t> SampleEvaluator::find(const std::string& column) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].name == column) return i;
  return std::nullopt;
}

// Collects the results of every run, without the chosen outputs. Settings may disable events (enabled: false): then
// columns are found by their names.
std::vector<double> SampleEvaluator::collect(const Scenario& scenario, const RunAnalysis& analysis) const {
  const std::vector<ResultColumn> own = list_columns(scenario);
  std::vector<double> values = collect_results(own, scenario, analysis);
  if (own == own_columns_) return values;
  std::vector<double> by_name(own_columns_.size(), kNothing);
  for (std::size_t i = 0; i < own.size(); ++i)
    if (const auto column = find(own[i].name); column && *column < by_name.size()) by_name[*column] = values[i];
  return by_name;
}

// One sample in progress. A mistake of its settings, or an exception of `look`, is its result.
class SampleEvaluator::Flight {
 public:
  Flight(const SampleEvaluator& evaluator, std::span<const Setting> settings, const SampleRun& run)
      : evaluator_(evaluator), run_(run) {
    guard([&] {
      scenario_.emplace(evaluator.tree_.read(settings));
      simulation_ = build_simulation(*scenario_, run.instruction_set);
      if (run.judges) analysis_.emplace(*scenario_, *simulation_, evaluator.request_);
      if (run.judges && !evaluator.chosen_.is_empty()) chosen_.emplace(evaluator.chosen_, *scenario_, *simulation_);
      if (!run.look && !run.end) simulation_->leave_distances_unread(list_read_sensors(*scenario_, chosen_));
      const std::int64_t last = calc_nearest_tick(run.until > 0 ? run.until : scenario_->until, scenario_->dt);
      flight_.emplace(*simulation_, analysis_ ? &*analysis_ : nullptr, nullptr, last, [this](const StepReport& report) {
        if (chosen_) chosen_->look();
        if (run_.look) run_.look(*scenario_, *simulation_, report);
      });
    });
  }
  Flight(const Flight&) = delete;
  Flight& operator=(const Flight&) = delete;

  [[nodiscard]] bool goes_on() const { return result_.status == SampleStatus::kDone && flight_ && flight_->goes_on(); }
  [[nodiscard]] const Simulation& get_simulation() const { return *simulation_; }

  // One step: begin() and, once it is taken, end(); or alone().
  BundleRun begin() {
    flight_->begin_tick();
    return simulation_->begin_step();
  }
  void end(const StepReport& report) {
    simulation_->end_step(report);
    guard([&] { flight_->end_tick(report); });
  }
  void step_alone() {
    flight_->begin_tick();
    const StepReport report = simulation_->step();
    guard([&] { flight_->end_tick(report); });
  }
  void interrupt() { flight_->interrupt(); }
  SampleResult finish() {
    if (result_.status == SampleStatus::kInvalid) return std::move(result_);
    guard([&] {
      const LogEnd end = flight_->finish();
      if (run_.end) run_.end(*simulation_);
      if (end.status == RunStatus::kAborted) result_.status = SampleStatus::kInterrupted;
      if (end.status == RunStatus::kFaulted) result_.status = SampleStatus::kFaulted;
      result_.message = end.message;
      result_.ticks = end.tick;
      result_.hash = end.hash;
      result_.model_hash = simulation_->get_model_hash();
      if (analysis_ && result_.status == SampleStatus::kDone) {
        result_.message = describe_unresolved(*scenario_, *analysis_);
        if (!result_.message.empty()) result_.status = SampleStatus::kUnresolved;
      }
      if (analysis_) result_.values = evaluator_.collect(*scenario_, *analysis_);
      if (analysis_ && evaluator_.chosen_.steps) result_.values.insert(result_.values.end(), {scenario_->dt, kNothing});
      if (chosen_)
        std::ranges::copy(chosen_->finish(end.status == RunStatus::kDone), std::back_inserter(result_.values));
      result_.values.resize(evaluator_.columns_.size(), kNothing);
    });
    return std::move(result_);
  }

 private:
  template <class Task>
  void guard(const Task& task) {
    try {
      task();
    } catch (const ScenarioError& error) {
      result_.status = SampleStatus::kInvalid;
      result_.message = error.what();
      result_.values.assign(evaluator_.columns_.size(), kNothing);
    }
  }

  const SampleEvaluator& evaluator_;
  const SampleRun& run_;
  std::optional<Scenario> scenario_;
  std::unique_ptr<Simulation> simulation_;
  std::optional<RunAnalysis> analysis_;
  std::optional<OutputTracker> chosen_;
  std::optional<FastRun> flight_;
  SampleResult result_;
};

void SampleEvaluator::fly_alone(Flight& flight, const std::atomic<bool>& stop) {
  while (flight.goes_on()) {
    if (stop.load(std::memory_order_relaxed)) return flight.interrupt();
    flight.step_alone();
  }
}

// Bundle of all flights, if they are still running and the kernel accepts them as one.
std::optional<Bundle> SampleEvaluator::build_bundle(std::span<Flight* const> flights) {
  std::vector<const Model*> models;
  std::vector<const Plan*> plans;
  for (const Flight* flight : flights) {
    models.push_back(&flight->get_simulation().model());
    plans.push_back(&flight->get_simulation().plan());
  }
  return Bundle::build(models, plans);
}

void SampleEvaluator::fly_together(Bundle& bundle, std::span<Flight* const> flights, const std::atomic<bool>& stop) {
  std::vector<BundleRun> runs(flights.size());
  const auto goes_on = [](const Flight* flight) { return flight->goes_on(); };
  while (std::ranges::any_of(flights, goes_on)) {
    if (stop.load(std::memory_order_relaxed)) {
      for (Flight* flight : flights)
        if (flight->goes_on()) flight->interrupt();
      return;
    }
    for (std::size_t i = 0; i < flights.size(); ++i) {
      if (flights[i]->goes_on())
        runs[i] = flights[i]->begin();
      else
        runs[i].goes_on = false;
    }
    bundle.step(runs);
    for (std::size_t i = 0; i < flights.size(); ++i)
      if (runs[i].goes_on) flights[i]->end(runs[i].report);
  }
}

std::vector<SampleResult> SampleEvaluator::evaluate(std::span<const SampleTask> tasks,
                                                    const std::atomic<bool>& stop) const {
  std::vector<std::unique_ptr<Flight>> flights;
  for (const SampleTask& task : tasks) flights.push_back(std::make_unique<Flight>(*this, task.settings, task.run));
  std::vector<Flight*> going;
  for (const auto& flight : flights)
    if (flight->goes_on()) going.push_back(flight.get());
  if (std::optional<Bundle> bundle = build_bundle(going))
    fly_together(*bundle, going, stop);
  else
    for (Flight* flight : going) fly_alone(*flight, stop);
  std::vector<SampleResult> results;
  for (const auto& flight : flights) results.push_back(flight->finish());
  return results;
}

SampleResult SampleEvaluator::evaluate(std::span<const Setting> settings, const std::atomic<bool>& stop,
                                       const SampleRun& run) const {
  Flight flight(*this, settings, run);
  fly_alone(flight, stop);
  return flight.finish();
}

SampleResult SampleEvaluator::evaluate(std::span<const Setting> settings) const {
  const std::atomic<bool> never{false};
  return evaluate(settings, never);
}

}  // namespace unlatch::hil
