// Outputs (hil/scenario/outputs.h) that are results of every sample: single values, and curves over time. A sample has
// one number for each, so that they are columns of the same table as all other results:
//
//   output.NAME.final    at the end; a sample that faults has none
//   output.NAME.min      least of all ticks, the first and the last included
//   output.NAME.max      greatest
//   curve.NAME@0.05      at that time, s
//
// step, step.error: of a campaign with a tolerance, the first of these columns. The step that the sample was flown at,
// s; and where it was checked at half of it (CampaignStep) its error, relative.
//
// NAME is a column of the output, such as core.vx; units are the output's. NaN: the sample ended before, or its values
// leave it without this output.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/outputs/output_reader.h"
#include "hil/study/evaluation/results.h"

namespace unlatch::hil {

struct ChosenOutput {
  enum class Take { kFinal, kMin, kMax };
  std::string name, unit;  // "core.vx", SI; "" for a plain number
  Take take = Take::kFinal;
};
extern const std::vector<std::string> kTakeNames;  // "final" …, in the order of the enum

// Curves at the times 0, every, 2 every, …
struct ChosenCurves {
  struct Curve {
    std::string name, unit;
  };
  std::vector<Curve> curves;
  double every = 0;        // s
  std::size_t points = 0;  // of each curve
  [[nodiscard]] double get_time(std::size_t point) const { return static_cast<double>(point) * every; }
};

struct ChosenOutputs {
  bool steps = false;  // the columns of the step
  std::vector<ChosenOutput> values;
  std::vector<ChosenCurves> curves;

  [[nodiscard]] bool is_empty() const { return values.empty() && curves.empty(); }  // of outputs
  [[nodiscard]] std::size_t count_steps() const { return steps ? 2 : 0; }
  [[nodiscard]] std::size_t count() const;  // columns
};

// Most columns of chosen outputs.
inline constexpr std::size_t kMostChosen = 4096;

// Columns of the results: of the step, and then in the order of OutputTracker::finish().
std::vector<ResultColumn> list_columns(const ChosenOutputs& chosen);
// Columns of every run, and after them these.
std::vector<ResultColumn> list_columns(const Scenario& scenario, const ChosenOutputs& chosen);

// Observes one run. It reads outputs only at ticks at which one is needed.
class OutputTracker {
 public:
  // Keeps references to all three.
  OutputTracker(const ChosenOutputs& chosen, const Scenario& scenario, const Simulation& simulation);

  // Sensors that it reads, by their numbers in the model.
  [[nodiscard]] std::vector<int> list_sensors() const;
  // Reads the present state; called at every state of the run, the first included.
  void look();
  // One number for each column of an output. `reached_end`: false for a run that faulted.
  [[nodiscard]] std::vector<double> finish(bool reached_end);

 private:
  using Places = std::vector<std::optional<std::size_t>>;  // among the reader's values; nothing: not in this scenario
  std::optional<std::size_t> find(const std::string& name, std::vector<std::size_t>& outputs) const;

  struct Series {
    Places places;
    std::vector<std::size_t> outputs;
    std::size_t next = 0;        // point
    std::vector<double> values;  // curve by curve
  };

  const ChosenOutputs& chosen_;
  const Simulation& simulation_;
  const double dt_;  // s
  OutputReader reader_;
  std::vector<double> scratch_;  // values of all outputs
  Places places_;                // of the single values
  std::vector<double> values_;   // likewise
  std::vector<std::size_t> at_every_tick_, at_the_end_;
  std::vector<Series> series_;
};

}  // namespace unlatch::hil
