#include "library/c/engine.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "hil/run/findings/findings.h"
#include "hil/run/linear/loop_margins.h"
#include "hil/run/replay.h"
#include "hil/run/run.h"
#include "hil/scenario/text/number_text.h"

namespace unlatch::library {

// --- A simulation and its replay ------------------------------------------------------------------------------------

Engine::Engine(hil::Scenario scenario, const LoadOptions& options)
    : scenario_(std::move(scenario)),
      flags_(options.flags),
      simulation_(hil::build_simulation(scenario_)),
      catalogue_(scenario_),
      initial_(simulation_->save()),
      events_(options.event_capacity),
      clearances_(scenario_.clearance.size()),
      verdicts_(scenario_.requirements.size()),
      verdict_views_(scenario_.requirements.size()) {
  begin_anew();
}

Engine::Engine(hil::RecordingReader recording, hil::Scenario scenario, const LoadOptions& options)
    : Engine(std::move(scenario), options) {
  if (simulation_->get_model_hash() != recording.header.model_hash)
    throw hil::LogError(recording.get_name() + ": was written by " + recording.header.program +
                        ", which compiles its scenario to another model; open it with that version");
  if (!recording.header.start.empty() &&
      !simulation_->restore(recording.header.start, recording.header.begins_unresolved))
    throw hil::LogError(recording.get_name() + ": begins at a state that its model cannot have");
  begin_anew();
  replay_ = std::make_unique<ReplayFeed>(std::move(recording), *simulation_);
  has_extras_ = true;
  if (!replay_->has_received()) return;
  received_.resize(simulation_->get_sensors().size());
  replay_->read_received(received_);
}

Engine::~Engine() {
  try {
    if (recording_) (void)stop_recording();
  } catch (...) {  // the file is incomplete; unlatch_stop_recording() reports the error
  }
}

ReplayFeed::ReplayFeed(hil::RecordingReader recording, hil::Simulation& simulation)
    : recording_(std::move(recording)), simulation_(simulation) {
  has_pending_ = recording_.next(pending_);
  if (!has_pending_) return;
  hil::refuse_if_lossy(recording_, pending_.unrecorded);
  if (pending_.hash != simulation_.calc_hash())
    throw hil::LogError(recording_.get_name() + ": its first state differs from that of its scenario");
}

unlatch_status ReplayFeed::step(StepReport& report) {
  if (!has_pending_) return UNLATCH_END;
  const bool has_next = recording_.next(next_);
  if (!has_next && !recording_.end) {  // nothing confirms that the pending step was made
    has_pending_ = false;
    return UNLATCH_END;
  }
  hil::refuse_if_lossy(recording_, has_next ? next_.unrecorded : recording_.end->unrecorded);
  for (const hil::LogChange& change : pending_.changes) hil::apply(change, simulation_);
  report = simulation_.step();
  has_pending_ = has_next && report.status == StepStatus::kOk;
  if (report.status != StepStatus::kOk) return UNLATCH_ERROR_FAULT;
  std::swap(pending_, next_);
  return compare(has_next ? pending_.hash : recording_.end->hash);
}

void ReplayFeed::read_received(std::span<double> to) const {
  std::ranges::copy(simulation_.get_sensors(), to.begin());
  for (const hil::LogReceived& one : recording_.received) to[static_cast<std::size_t>(one.value)] = one.received;
}

unlatch_status ReplayFeed::compare(std::int64_t recorded) {
  if (simulation_.calc_hash() == recorded) return UNLATCH_OK;
  has_pending_ = false;
  return fail(
      UNLATCH_ERROR_DIFFERENCE,
      recording_.get_name() + ": tick " + std::to_string(simulation_.get_tick()) + " differs from the recording",
      recording_.get_name());
}

// --- Steps ----------------------------------------------------------------------------------------------------------

unlatch_status Engine::fault(const StepReport& report) noexcept {
  return guard([&] {
    hil::LogEnd end;
    end.status = hil::RunStatus::kFaulted;
    end.step_status = static_cast<std::int32_t>(report.status);
    end.joint = report.joint;
    end.tick = simulation_->get_tick();
    const std::string text = hil::describe_fault(report, end.tick, scenario_.model, scenario_.dt);
    if (recording_) {
      end.message = text;
      close_recording(std::move(end));
    }
    const bool at_joint = report.joint >= 0 && static_cast<std::size_t>(report.joint) < scenario_.model.joints.size();
    return fail(UNLATCH_ERROR_FAULT, text, scenario_.file,
                at_joint ? "joints." + scenario_.model.joints[static_cast<std::size_t>(report.joint)].name : "");
  });
}

void Engine::keep_events(const StepReport& report) noexcept {
  for (const FiredEvent& fired : report.events) {
    if (event_count_ == events_.size()) {
      ++lost_events_;
    } else {
      events_[event_count_++] = {fired.time, simulation_->get_tick() - 1, fired.event};
    }
  }
}

void Engine::record_inputs() noexcept {
  const std::span<const double> channels = std::as_const(*simulation_).channels();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    double& recorded = recording_->channels[i];
    if (std::bit_cast<std::uint64_t>(recorded) == std::bit_cast<std::uint64_t>(channels[i])) continue;
    recorded = channels[i];
    recording_->record.change(i, recorded);
  }
  recording_->record.tick();
}

unlatch_status Engine::step_with_extras() noexcept {
  return guard([&]() -> unlatch_status {
    StepReport report;
    if (replay_) {
      const unlatch_status status = replay_->step(report);
      if (status == UNLATCH_ERROR_FAULT) return fault(report);
      if (status != UNLATCH_OK) return status;
      if (!received_.empty()) replay_->read_received(received_);
    } else {
      if (recording_) record_inputs();
      report = simulation_->step();
      if (report.status != StepStatus::kOk) return fault(report);
    }
    keep_events(report);
    if (recording_) {
      recording_->record.events(report);
      recording_->record.state(hil::RunStatus::kRunning);
    }
    if (analysis_) {
      analysis_->update(report);
      for (std::size_t i = 0; i < clearances_.size(); ++i) clearances_[i] = analysis_->clearances()[i].now;
    }
    if (notices_) notices_->update(report);
    return UNLATCH_OK;
  });
}

unlatch_status Engine::advance(std::uint64_t ticks, std::uint32_t flags, std::uint64_t& done,
                               std::atomic<bool>& interrupted) noexcept {
  const bool stops = (flags & UNLATCH_STOP_AT_EVENTS) != 0;
  for (done = 0; done < ticks;) {
    if (interrupted.load(std::memory_order_relaxed)) {
      interrupted.store(false, std::memory_order_relaxed);
      return UNLATCH_INTERRUPTED;
    }
    const std::uint64_t before = event_count_ + lost_events_;
    const unlatch_status status = step();
    if (status != UNLATCH_OK) return status;
    ++done;
    if (stops && event_count_ + lost_events_ != before) return UNLATCH_EVENT;
  }
  return UNLATCH_OK;
}

unlatch_status Engine::set_channels(std::size_t first, std::size_t count, const double* values) noexcept {
  const std::vector<unlatch_item>& channels = catalogue_.get(UNLATCH_CHANNEL);
  if (replay_) return fail(UNLATCH_ERROR_ORDER, "a replay takes its commands from the recording");
  if (first > channels.size() || count > channels.size() - first) {
    return guard([&] {
      return fail(UNLATCH_ERROR_RANGE, "channels " + std::to_string(first) + " and on, " + std::to_string(count) +
                                           " of them; there are " + std::to_string(channels.size()));
    });
  }
  for (std::size_t i = 0; i < count; ++i) {
    const unlatch_item& channel = channels[first + i];
    if (values[i] >= channel.minimum && values[i] <= channel.maximum) continue;  // false for NaN
    return guard([&] {
      return fail(UNLATCH_ERROR_RANGE,
                  "channel '" + std::string(channel.name) + "': " + hil::write_number(values[i]) +
                      " is outside its range, " + hil::write_number(channel.minimum) + " to " +
                      hil::write_number(channel.maximum) + " " + channel.unit,
                  scenario_.file, std::string("channels.") + channel.name);
    });
  }
  for (std::size_t i = 0; i < count; ++i) simulation_->set_channel(first + i, values[i]);
  return UNLATCH_OK;
}

// --- Verdicts and findings ------------------------------------------------------------------------------------------

unlatch_status Engine::judge(const unlatch_verdict** verdicts, std::size_t* count) {
  if (!analysis_)
    return fail(UNLATCH_ERROR_ORDER,
                "this simulation does not judge; load it with UNLATCH_JUDGE in the options' flags");
  verdicts_ = analysis_->judge();
  certainties_.clear();
  for (std::size_t i = 0; i < verdicts_.size(); ++i) {
    const hil::Verdict& verdict = verdicts_[i];
    if (!verdicts_[i].is_resolved()) verdicts_[i].why = "unresolved: " + verdicts_[i].unresolved;
    verdict_views_[i] = {verdict.evaluated && verdict.is_resolved(),
                         verdict.is_met(),
                         verdict.value,
                         verdict.limit,
                         verdict.margin,
                         verdict.time,
                         verdict.why.c_str()};
    certainties_.push_back({verdict.uncertainty, verdict.at_ticks ? 1 : 0});
  }
  *verdicts = verdict_views_.data();
  *count = verdict_views_.size();
  return UNLATCH_OK;
}

unlatch_status Engine::get_certainties(const unlatch_certainty** certainties, std::size_t* count) const {
  *certainties = certainties_.data();
  *count = certainties_.size();
  return UNLATCH_OK;
}

unlatch_status Engine::get_findings(const unlatch_finding** findings, std::size_t* count) {
  if (!findings_) findings_ = hil::list_findings(scenario_, *hil::build_simulation(scenario_));
  finding_views_.clear();
  for (const hil::Finding& finding : *findings_)
    finding_views_.push_back({0, 0, 0, 0, finding.name.c_str(), finding.where.c_str(), finding.text.c_str()});
  told_ = get_notices() != nullptr ? get_notices()->get() : std::vector<hil::RunNotice>{};
  for (const hil::RunNotice& notice : told_)
    finding_views_.push_back({1, notice.unresolved, notice.time, notice.worst_time, notice.name.c_str(),
                              notice.subject.c_str(), notice.text.c_str()});
  *findings = finding_views_.data();
  *count = finding_views_.size();
  return UNLATCH_OK;
}

unlatch_status Engine::linearize(const unlatch_linear_model** model) {
  try {
    linear_.emplace(hil::linearize(scenario_, *simulation_));
  } catch (const hil::LinearizationError& error) {
    return fail(UNLATCH_ERROR_FAULT, error.what());
  }
  *model = &linear_->get();
  return UNLATCH_OK;
}

namespace {

unlatch_status refuse_without_model() {
  return fail(UNLATCH_ERROR_ORDER, "there is no linear model yet: unlatch_linearize() makes it");
}

}  // namespace

unlatch_status Engine::get_linear_response(const unlatch_linear_response** response) const {
  if (!linear_) return refuse_without_model();
  *response = &linear_->get_response();
  return UNLATCH_OK;
}

unlatch_status Engine::calc_margins(const char* loop, double period, double delay,
                                    unlatch_loop_margins* margins) const {
  if (!linear_) return refuse_without_model();
  if (!(period >= 0 && std::isfinite(period) && delay >= 0 && std::isfinite(delay)))
    return fail(UNLATCH_ERROR_RANGE, "the period and the delay of a loop are times in s, at least 0");
  hil::LoopMargins found;
  try {
    hil::LoopRequest request = hil::parse_loop(loop);
    request.period = period;
    request.delay = delay;
    found = hil::calc_margins(linear_->get_system(), request);
  } catch (const hil::LinearizationError& error) {
    return fail(UNLATCH_ERROR_ARGUMENT, error.what());
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto put = [](const std::optional<hil::LoopMargins::At>& from, double& value, double& frequency) {
    value = from ? from->value : kNone;
    frequency = from ? from->frequency : kNone;
  };
  margins->stable = found.stable ? 1 : 0;
  put(found.gain, margins->gain, margins->gain_frequency);
  put(found.drop, margins->drop, margins->drop_frequency);
  put(found.phase, margins->phase, margins->phase_frequency);
  put(found.delay, margins->delay, margins->delay_frequency);
  return UNLATCH_OK;
}

// Restarts events, verdicts, notices and clearances at the present state.
void Engine::begin_anew() {
  event_count_ = 0;
  lost_events_ = 0;
  if (flags_ == UNLATCH_NOTICE) {
    constexpr bool kAudits = false;
    notices_ = std::make_unique<hil::NoticeWatch>(scenario_, *simulation_, kAudits);
    notices_->update(StepReport{});
    has_extras_ = true;
  }
  if ((flags_ & UNLATCH_JUDGE) == 0) return;
  analysis_ = std::make_unique<hil::RunAnalysis>(scenario_, *simulation_);
  analysis_->update(StepReport{});
  for (std::size_t i = 0; i < clearances_.size(); ++i) clearances_[i] = analysis_->clearances()[i].now;
  has_extras_ = true;
}

}  // namespace unlatch::library
