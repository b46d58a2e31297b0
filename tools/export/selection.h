// Selection of a run for export: groups of outputs, each with the ticks at which it goes out, and the events in
// between.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/outputs/output_reader.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::tools {

// Groups without the outputs of other bodies than these; none: all. Throws std::invalid_argument for a name that the
// scenario does not have.
std::vector<hil::SelectedOutputs> keep_bodies(std::vector<hil::SelectedOutputs> groups, const hil::Scenario& scenario,
                                              std::span<const hil::Output> list,
                                              const std::vector<std::string>& bodies);

class Selection {
 public:
  // A group goes out at its ticks; the first tick and `last_tick` have every group. Scenario, simulation and analysis
  // must outlive it. The analysis, if there is one, is updated before each look(), and gives the shapes of touches.
  Selection(const hil::Scenario& scenario, const hil::Simulation& simulation, std::vector<hil::SelectedOutputs> groups,
            std::int64_t last_tick, hil::SensorsShown shown = hil::SensorsShown::kAsScenario,
            const hil::RunAnalysis* analysis = nullptr);

  // At every state, with what the step that led there reported, and the events of the session since the state before:
  // whether this tick goes out.
  bool look(const StepReport& report, std::span<const hil::EventMessage> session = {});
  // Before look(): see OutputReader.
  void set_received(std::span<const hil::LogReceived> received) { reader_.set_received(received); }
  // The last state of a run that ended early goes out with every group: false if it has gone out already.
  bool look_at_end();

  [[nodiscard]] const hil::Scenario& scenario() const { return scenario_; }
  [[nodiscard]] const hil::Simulation& simulation() const { return simulation_; }
  [[nodiscard]] const hil::OutputReader& reader() const { return reader_; }
  // Of the model and of the session, since the tick that went out before; in the order of their times.
  [[nodiscard]] const std::vector<hil::TimelineEntry>& events() const { return events_; }
  // Outputs of all groups, ascending; and those that are due at the tick that goes out.
  [[nodiscard]] const std::vector<std::size_t>& outputs() const { return outputs_; }
  [[nodiscard]] const std::vector<std::size_t>& due() const { return due_; }
  [[nodiscard]] bool is_due(std::size_t output) const { return is_due_[output]; }
  // Some ticks that go out have only some outputs.
  [[nodiscard]] bool has_gaps() const { return groups_.size() > 1; }
  // Values of all outputs; those that are not due have older values.
  [[nodiscard]] std::span<const double> values() const { return values_; }

 private:
  bool begin_tick(bool all);

  const hil::Scenario& scenario_;
  const hil::Simulation& simulation_;
  hil::OutputReader reader_;
  const std::vector<hil::SelectedOutputs> groups_;
  const std::int64_t last_tick_;
  const hil::RunAnalysis* const analysis_;
  std::size_t seen_ = 0;  // entries of its timeline
  std::vector<std::size_t> outputs_, due_;
  std::vector<bool> is_due_;
  std::vector<double> values_;
  std::vector<hil::TimelineEntry> events_;
  bool events_are_out_ = false;
  std::int64_t out_tick_ = -1;  // of the last one that went out
};

}  // namespace unlatch::tools
