// The result of a run, of any kind, as JSON for programs and as tables for readers.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hil/analysis/accuracy.h"
#include "hil/analysis/run_analysis.h"
#include "hil/outputs/run_outputs.h"
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
  std::optional<hil::AccuracyReport> accuracy = {};
  const hil::RunOutputs* outputs = nullptr;  // samples and series; none: neither is told
};

std::string to_hex(std::int64_t hash);
const char* get_status_name(hil::RunStatus status);

// Verdicts on a separation, a sentence each: bodies that did not separate, that separated late, that collided.
std::vector<std::string> build_verdicts(const RunReport& report);

nlohmann::ordered_json build_json(const RunReport& report);
void write_json(const RunReport& report, const std::string& target);
void print_report(std::FILE* to, const RunReport& report);

// Destination of --json: none, standard output ("-"), or a file. Throws OutputError.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
void write_json(const nlohmann::ordered_json& json, const std::string& target);
void write_text(const std::string& text, const std::string& target);  // whole, or the file stays as it was
// The same error before the work rather than after it: a target that cannot be created. Leaves no file.
void check_output(const std::string& target);

// The same for results that come one after another, one object a line, each out at once. Nowhere: nothing is written.
class JsonLines {
 public:
  explicit JsonLines(const std::string& target);
  void write(const std::string& json);  // an object in one line

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  const std::string target_;
  std::unique_ptr<std::FILE, Close> file_;
};
// People's text goes to standard error when standard output is JSON's.
inline std::FILE* get_people_stream(const std::string& json_target) { return json_target == "-" ? stderr : stdout; }

}  // namespace unlatch::tools
