// Options of `hil` for the pace.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hil/session/realtime/real_time.h"
#include "hil/session/realtime/tick_source.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {

struct PacingOptions {
  std::string overruns, source;  // empty: as the scenario says; the clock
  double spin_us = -1;           // < 0: as the scenario says
  bool tick_times = false;
  hil::RealTimeOptions thread;

  // The options that a scenario has too, as overrides of it, so that the recording contains them.
  void add_overrides(std::vector<std::string>& overrides) const;
  // Null for the clock. Refuses what cannot be opened, as refuse_option() does. A file that was opened stays open.
  [[nodiscard]] std::unique_ptr<hil::TickSource> open_source(std::int64_t period_ns) const;
  // Longest wait for a tick from outside, ns; 0 for the clock.
  [[nodiscard]] std::int64_t get_patience_ns() const;
};

// "" or the mistake: this is not the number of a CPU of this machine.
std::string check_cpu(const std::string& text);
void add_pacing_options(Command command, PacingOptions& options);

}  // namespace unlatch::tools
