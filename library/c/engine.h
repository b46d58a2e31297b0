// The object behind a handle of a simulation: the scenario, its simulation, and the stored data of the run. Stepping
// allocates nothing unless it judges, notices, replays or records.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/findings/finding.h"
#include "hil/run/notices/notices.h"
#include "hil/run/recording/replay_reader.h"
#include "hil/run/run_record.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"
#include "library/c/catalogue.h"
#include "library/c/errors.h"
#include "library/c/linear_view.h"
#include "library/c/options.h"
#include "library/include/unlatch.h"

namespace unlatch::library {

// Steps of a recording: applies its commands, and compares the hashes.
class ReplayFeed {
 public:
  // `simulation` is at the state where the recording begins. Throws LogError.
  ReplayFeed(hil::RecordingReader recording, hil::Simulation& simulation);
  // Makes one tick. UNLATCH_OK, UNLATCH_END, UNLATCH_ERROR_DIFFERENCE or UNLATCH_ERROR_FAULT; `report` is the report of
  // the step.
  unlatch_status step(StepReport& report);

  // The recording has the sensors as flight software received them, here those at the present state.
  [[nodiscard]] bool has_received() const { return recording_.header.has_received; }
  void read_received(std::span<double> to) const;

 private:
  unlatch_status compare(std::int64_t recorded);

  hil::RecordingReader recording_;
  hil::Simulation& simulation_;
  hil::LogTick pending_, next_;
  bool has_pending_ = false;
};

class Engine {
 public:
  // Simulates a scenario. Throws ScenarioError.
  Engine(hil::Scenario scenario, const LoadOptions& options);
  // Replays a recording. Throws LogError, ScenarioError.
  Engine(hil::RecordingReader recording, hil::Scenario scenario, const LoadOptions& options);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  unlatch_status step() noexcept {
    if (has_extras_) return step_with_extras();
    const StepReport report = simulation_->step();
    if (report.status != StepStatus::kOk) return fault(report);
    if (!report.events.empty()) keep_events(report);
    return UNLATCH_OK;
  }
  unlatch_status advance(std::uint64_t ticks, std::uint32_t flags, std::uint64_t& done,
                         std::atomic<bool>& interrupted) noexcept;
  unlatch_status set_channels(std::size_t first, std::size_t count, const double* values) noexcept;

  unlatch_status get_array(std::int32_t which, std::size_t index, unlatch_array& array) const;
  void get_events(const unlatch_event** events, std::size_t* count, std::uint64_t* lost) const {
    *events = events_.data();
    *count = event_count_;
    if (lost != nullptr) *lost = lost_events_;
  }
  unlatch_status judge(const unlatch_verdict** verdicts, std::size_t* count);
  unlatch_status get_certainties(const unlatch_certainty** certainties, std::size_t* count) const;
  unlatch_status get_findings(const unlatch_finding** findings, std::size_t* count);
  unlatch_status linearize(const unlatch_linear_model** model);
  unlatch_status get_linear_response(const unlatch_linear_response** response) const;
  unlatch_status calc_margins(const char* loop, double period, double delay, unlatch_loop_margins* margins) const;

  unlatch_status save(void* buffer, std::size_t capacity, std::size_t* needed) const;
  unlatch_status restore(const void* buffer, std::size_t length);
  unlatch_status reset();

  unlatch_status start_recording(const char* path);
  unlatch_status stop_recording();

  [[nodiscard]] const hil::Scenario& scenario() const { return scenario_; }
  [[nodiscard]] const hil::Simulation& simulation() const { return *simulation_; }
  [[nodiscard]] const Catalogue& catalogue() const { return catalogue_; }

 private:
  // State of a recording in progress.
  struct Recording {
    Recording(const std::string& path, const hil::LogHeader& header, const hil::Simulation& simulation)
        : recorder(path, header),
          record(simulation, &recorder),
          channels(simulation.channels().begin(), simulation.channels().end()) {}
    hil::Recorder recorder;
    hil::RunRecord record;
    std::vector<double> channels;  // as recorded so far
  };

  unlatch_status step_with_extras() noexcept;
  unlatch_status fault(const StepReport& report) noexcept;
  void keep_events(const StepReport& report) noexcept;
  void record_inputs() noexcept;
  void close_recording(hil::LogEnd end);
  unlatch_status restore_words(std::span<const std::uint64_t> words, bool unresolved);
  // The step has not resolved something of the run so far, or of the one that led to its first state.
  bool is_unresolved() const;
  void begin_anew();
  // Notices of the run; null without UNLATCH_JUDGE and UNLATCH_NOTICE.
  [[nodiscard]] const hil::NoticeWatch* get_notices() const {
    return analysis_ ? &analysis_->accuracy() : notices_.get();
  }
  [[nodiscard]] unlatch_status refuse_while_busy(const char* what) const;

  const hil::Scenario scenario_;
  const std::uint32_t flags_;
  std::unique_ptr<hil::Simulation> simulation_;
  const Catalogue catalogue_;
  const std::vector<std::uint64_t> initial_;  // saved initial state
  std::vector<unlatch_event> events_;
  std::size_t event_count_ = 0;
  std::uint64_t lost_events_ = 0;

  bool has_extras_ = false;
  std::unique_ptr<ReplayFeed> replay_;
  std::unique_ptr<hil::RunAnalysis> analysis_;  // with UNLATCH_JUDGE
  std::unique_ptr<hil::NoticeWatch> notices_;   // with UNLATCH_NOTICE alone
  std::unique_ptr<Recording> recording_;
  std::string recording_error_;  // error of a recording that a fault has ended
  bool recording_ended_ = false;
  std::vector<double> clearances_;
  std::vector<double> received_;  // of a replayed session
  std::vector<hil::Verdict> verdicts_;
  std::vector<unlatch_verdict> verdict_views_;
  std::vector<unlatch_certainty> certainties_;         // of verdicts_
  std::optional<std::vector<hil::Finding>> findings_;  // about the scenario, from the first call on
  std::vector<hil::RunNotice> told_;                   // notices of finding_views_
  std::vector<unlatch_finding> finding_views_;
  std::optional<LinearView> linear_;  // of the latest linearize()
};

}  // namespace unlatch::library
