#include "tools/unlatch/recordings/replayed_log.h"

#include "tools/unlatch/options/output_options.h"
#include "tools/unlatch/results/accuracy_report.h"

namespace unlatch::tools {
namespace {

std::string describe_end(const hil::RecordingReader& recording, std::int64_t tick) {
  if (recording.end) return recording.end->message;
  return "the recording is not complete: " + recording.shortfall + "; replayed up to tick " + std::to_string(tick);
}

}  // namespace

std::string describe_status(const hil::RecordingReader& recording, const hil::ReplayResult& result) {
  if (!result.agrees()) return "different";
  if (recording.damaged) return "damaged";
  if (!recording.end) return "truncated";
  return get_status_name(recording.end->status);
}

OpenedLog::OpenedLog(const std::string& path)
    : recording(hil::LogFileReader(path)),
      scenario(hil::load_recorded_scenario(recording.header)),
      simulation(hil::build_recorded_simulation(recording.header, scenario, path)) {}

ReplayedLog::ReplayedLog(const std::string& path, const std::string& chosen)
    : opened(path),
      analysis(opened.scenario, *opened.simulation),
      outputs(opened.scenario, *opened.simulation, {opened.recording.header.last_tick},
              choose_outputs(opened.scenario, chosen, hil::get_sensors_shown(opened.recording.header)),
              hil::get_sensors_shown(opened.recording.header)) {}

void ReplayedLog::replay(const std::function<void(const StepReport&)>& look) {
  result = hil::replay(opened.recording, *opened.simulation, &analysis, [&](const StepReport& report) {
    outputs.look(opened.recording.received);
    if (look) look(report);
  });
  outputs.finish();
}

RunReport ReplayedLog::build_report() const {
  const hil::RecordingReader& recording = opened.recording;
  const hil::Simulation& simulation = *opened.simulation;
  std::string status = describe_status(recording, result), message = describe_end(recording, simulation.get_tick());
  tell_unresolved(analysis, status, message);
  return {opened.scenario,
          simulation,
          analysis,
          status,
          message,
          simulation.get_tick(),
          simulation.calc_hash(),
          recording.end ? recording.end->timing : hil::TimingSummary{},
          recording.notices,
          result,
          {},
          {},
          {},
          &outputs,
          recording.events,
          recording.events_left_out};
}

}  // namespace unlatch::tools
