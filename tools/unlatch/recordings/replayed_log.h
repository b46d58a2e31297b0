// Replay of a recording, and its result.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tools/unlatch/results/report.h"

namespace unlatch::tools {

// A recording, and a simulation at its beginning. Throws as hil/run/replay.h says.
struct OpenedLog {
  explicit OpenedLog(const std::string& path);
  hil::RecordingReader recording;
  const hil::Scenario scenario;
  const std::unique_ptr<hil::Simulation> simulation;
};

// "ok", "fault", "aborted"; "different", "damaged", "truncated".
std::string describe_status(const hil::RecordingReader& recording, const hil::ReplayResult& result);

struct ReplayedLog {
  // `outputs`: as of choose_outputs(), for the series.
  explicit ReplayedLog(const std::string& path, const std::string& outputs = {});
  // Once. `look` is called at every state, after the analysis.
  void replay(const std::function<void(const StepReport&)>& look = {});
  // After that; it refers to this.
  [[nodiscard]] RunReport build_report() const;
  [[nodiscard]] bool is_sound() const { return result.agrees() && !opened.recording.damaged; }

  OpenedLog opened;
  hil::RunAnalysis analysis;
  hil::RunOutputs outputs;
  hil::ReplayResult result;
};

}  // namespace unlatch::tools
