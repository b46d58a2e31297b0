// The result of a run, of any kind, as JSON for programs and as tables for readers.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/analysis/accuracy.h"
#include "hil/run/analysis/run_analysis.h"
#include "hil/run/outputs/run_outputs.h"
#include "hil/run/replay.h"

namespace unlatch::tools {

struct RunReport {
  const hil::Scenario& scenario;
  const hil::Simulation& simulation;  // at its last state
  const hil::RunAnalysis& analysis;
  std::string status = "ok";        // or fault, aborted, truncated, damaged, different
  std::string message;              // why, if not ok
  std::int64_t tick = 0, hash = 0;  // of the last state
  hil::TimingSummary timing;
  std::vector<hil::EventMessage> notices;  // participants, policies, faults
  std::optional<hil::ReplayResult> replay;
  std::vector<std::string> refused = {};  // by the operating system, to a run in real time
  std::vector<std::string> unfit = {};    // readers and writers that DDS has not connected, a sentence each
  std::optional<hil::AccuracyReport> accuracy = {};
  const hil::RunOutputs* outputs = nullptr;  // samples and series; none: neither is written
  // Events of the session, notices among them: faults, policies, participants, refused, late, overruns.
  std::vector<hil::EventMessage> session_events = {};
  std::int64_t session_events_left_out = 0;  // there were too many to keep
};

const char* get_status_name(hil::RunStatus status);

// Verdicts on a separation, a sentence each: bodies that did not separate, that separated late, that collided.
std::vector<std::string> build_verdicts(const RunReport& report);

nlohmann::ordered_json build_json(const RunReport& report);
void write_json(const RunReport& report, const std::string& target);
void print_report(std::FILE* to, const RunReport& report);

}  // namespace unlatch::tools
