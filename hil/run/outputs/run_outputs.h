// Collects outputs during a run: all of them at some ticks, and the selected ones over the run, each group at its own
// rate. Memory grows with the rows.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/run/outputs/output_reader.h"

namespace unlatch::hil {

class RunOutputs {
 public:
  struct Sample {
    double time = 0;             // s
    std::vector<double> values;  // values of all outputs
  };
  struct Series {
    SelectedOutputs selected;
    std::vector<double> times;   // s, one for each row
    std::vector<double> values;  // row by row, the columns of the selected outputs
  };

  // `samples`: ticks, in any order; `groups`: empty for no series. Keeps references to scenario and simulation.
  RunOutputs(const Scenario& scenario, const Simulation& simulation, std::vector<std::int64_t> samples,
             const std::vector<OutputGroup>& groups, SensorsShown shown = SensorsShown::kAsScenario);

  // Reads the present state; called at every state of the run, the first included. `received`: see OutputReader.
  void look(std::span<const LogReceived> received = {});
  // Adds the last state to every series.
  void finish();

  [[nodiscard]] const OutputReader& reader() const { return reader_; }
  // Samples in the order of their ticks.
  [[nodiscard]] const std::vector<Sample>& get_samples() const { return samples_; }
  [[nodiscard]] const std::vector<Series>& get_series() const { return series_; }

 private:
  void add_row(Series& series);

  const Simulation& simulation_;
  OutputReader reader_;
  std::vector<std::int64_t> sample_ticks_;  // ascending
  std::size_t next_sample_ = 0;
  std::int64_t last_tick_ = -1;  // latest tick that was read
  std::vector<Sample> samples_;
  std::vector<Series> series_;
  std::vector<std::int64_t> last_rows_;  // tick of the latest row, by series
  std::vector<double> values_;           // scratch
};

}  // namespace unlatch::hil
