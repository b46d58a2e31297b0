// Outputs gathered while a run goes: everything at some ticks, and the selected outputs over the run, each group at its
// own rate. Memory grows with the rows.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/outputs/output_reader.h"

namespace unlatch::hil {

class RunOutputs {
 public:
  struct Sample {
    double time = 0;             // s
    std::vector<double> values;  // of all outputs
  };
  struct Series {
    SelectedOutputs selected;
    std::vector<double> times;   // s, one for each row
    std::vector<double> values;  // row after row, the columns of the selected outputs
  };

  // `samples`: ticks, in any order; `groups`: none, and there is no series. Scenario and simulation must
  // outlive it.
  RunOutputs(const Scenario& scenario, const Simulation& simulation, std::vector<std::int64_t> samples,
             const std::vector<OutputGroup>& groups);

  // At every state of the run, the first included.
  void look();
  // The last state belongs to every series.
  void finish();

  [[nodiscard]] const OutputReader& reader() const { return reader_; }
  // In the order of their ticks.
  [[nodiscard]] const std::vector<Sample>& get_samples() const { return samples_; }
  [[nodiscard]] const std::vector<Series>& get_series() const { return series_; }

 private:
  void add_row(Series& series);

  const Simulation& simulation_;
  OutputReader reader_;
  std::vector<std::int64_t> sample_ticks_;  // ascending
  std::size_t next_sample_ = 0;
  std::int64_t last_tick_ = -1;  // looked at
  std::vector<Sample> samples_;
  std::vector<Series> series_;
  std::vector<std::int64_t> last_rows_;  // tick of the latest row, by series
  std::vector<double> values_;           // scratch
};

}  // namespace unlatch::hil
