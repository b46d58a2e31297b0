#include "hil/run/outputs/run_outputs.h"

#include <algorithm>

namespace unlatch::hil {

RunOutputs::RunOutputs(const Scenario& scenario, const Simulation& simulation, std::vector<std::int64_t> samples,
                       const std::vector<OutputGroup>& groups, SensorsShown shown)
    : simulation_(simulation),
      reader_(scenario, simulation, shown),
      sample_ticks_(std::move(samples)),
      values_(reader_.count_values()) {
  std::ranges::sort(sample_ticks_);
  for (SelectedOutputs& selected : select(reader_.list(), groups)) series_.push_back({std::move(selected), {}, {}});
  last_rows_.assign(series_.size(), -1);
}

void RunOutputs::look(std::span<const LogReceived> received) {
  reader_.set_received(received);
  const std::int64_t tick = simulation_.get_tick();
  const bool first = last_tick_ < 0;
  last_tick_ = tick;
  for (; next_sample_ < sample_ticks_.size() && sample_ticks_[next_sample_] <= tick; ++next_sample_) {
    if (sample_ticks_[next_sample_] != tick) continue;
    reader_.read(values_);
    samples_.push_back({simulation_.get_time(), values_});
  }
  for (Series& series : series_)
    if (first || series.selected.rate.is_due(tick)) add_row(series);
}

void RunOutputs::finish() {
  for (std::size_t i = 0; i < series_.size(); ++i)
    if (last_tick_ >= 0 && last_rows_[i] != simulation_.get_tick()) add_row(series_[i]);
}

void RunOutputs::add_row(Series& series) {
  last_rows_[static_cast<std::size_t>(&series - series_.data())] = simulation_.get_tick();
  reader_.read(series.selected.outputs, values_);
  series.times.push_back(simulation_.get_time());
  for (const std::size_t i : series.selected.outputs) {
    const Output& output = reader_.list()[i];
    const auto from = values_.begin() + static_cast<std::ptrdiff_t>(output.first);
    series.values.insert(series.values.end(), from, from + static_cast<std::ptrdiff_t>(output.columns.size()));
  }
}

}  // namespace unlatch::hil
