// Selection of a run for export: the chosen bodies, every n-th tick, and the events in between.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/analysis/clearance.h"
#include "hil/analysis/run_analysis.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::tools {

class Selection {
 public:
  // `bodies`: names; none: all. All ticks that are a multiple of `every`, the first and the last. All must outlive it.
  // Throws std::invalid_argument for a name that the scenario does not have.
  Selection(const hil::Scenario& scenario, const hil::Simulation& simulation, const std::vector<std::string>& bodies,
            std::int64_t every);

  // At every state, with what the step that led there reported: whether this tick goes out.
  bool look(const StepReport& report);
  // The last state goes out even if it is not its turn: false if it has gone out already.
  bool look_at_end();

  [[nodiscard]] const hil::Scenario& scenario() const { return scenario_; }
  [[nodiscard]] const hil::Simulation& simulation() const { return simulation_; }
  [[nodiscard]] const std::vector<std::size_t>& bodies() const { return bodies_; }
  // Since the tick that went out before.
  [[nodiscard]] const std::vector<hil::TimelineEntry>& events() const { return events_; }
  // Of the pairs that the scenario watches.
  [[nodiscard]] const std::vector<hil::Clearance>& clearances() const { return clearances_.get(); }
  [[nodiscard]] const JointMode& get_mode(std::size_t joint) const;
  // Modal coordinates of a flexible body, kg^0.5 m; empty for a rigid one.
  [[nodiscard]] std::span<const double> get_modal(std::size_t body) const;

 private:
  void begin_tick();

  const hil::Scenario& scenario_;
  const hil::Simulation& simulation_;
  std::vector<std::size_t> bodies_;
  const std::int64_t every_;
  std::vector<hil::TimelineEntry> events_;
  bool events_are_out_ = false;
  std::int64_t out_tick_ = -1;  // of the last one that went out
  hil::ClearanceMonitor clearances_;
  std::vector<hil::Pose> poses_;
};

}  // namespace unlatch::tools
