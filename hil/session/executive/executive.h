// The cyclic executive: steps a simulation at its pace, with flight software in the loop, and accounts for every tick.
//
//   real time  wait for the tick → receive → apply commands → step → publish → account for the time
//              (with a spin before each tick: sleep → warm-up step → busy-wait)
//   lockstep   publish the State → wait until every required participant has answered → apply commands → step → account
//   fast       step → publish → account
//
// The loop has no allocation, lock, file or logging; it communicates through a Connection and a Recorder alone (in real
// time the connection is two rings; in lockstep, which has no deadline to miss, it may lead to the middleware itself).
// Wall time decides whether a participant is alive, simulated time everything else. When a required participant does
// not answer within its limit, the scenario's policy is applied and recorded, and the run goes on without it until it
// comes back (hold, zero, safe) or for good (evict), waits for it (pause) or ends (abort). The protocol:
// hil/PROTOCOL.md.
//
// Executive is the cycle alone. A Session (session.h) owns what concerns participants: Participants, Handshake,
// Liveness, CommandQueue, Publisher and StateExchange. ChannelWriter, HealthReporter, Heartbeat and WarmUp are the
// executive's own. Each part has a test of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hil/run/recording/recorder.h"
#include "hil/run/simulation/simulation.h"
#include "hil/session/executive/channel_writer.h"
#include "hil/session/executive/executive_options.h"
#include "hil/session/executive/health_reporter.h"
#include "hil/session/executive/heartbeat.h"
#include "hil/session/executive/session.h"
#include "hil/session/executive/session_start.h"
#include "hil/session/executive/warm_up.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/executive_timing.h"
#include "hil/session/realtime/nonblocking.h"
#include "hil/session/realtime/tick_source.h"

namespace unlatch::hil {

class Executive {
 public:
  // All arguments but `options` must outlive the executive. `scenario` is the name that participants get.
  Executive(Simulation& simulation, Connection& connection, Recorder& recorder, const std::string& scenario,
            const ExecutiveOptions& options);

  // Runs from the introductions to the end, on the calling thread.
  [[nodiscard]] LogEnd run();

  // Ends the run, as aborted, within a tick or some milliseconds. Any thread, or a signal handler.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  // One watching thread.
  [[nodiscard]] std::int64_t get_tick() const noexcept { return heartbeat_.get_tick(); }
  [[nodiscard]] bool take_notice(EventMessage& event) noexcept { return session_.publisher().take_notice(event); }
  // Call about once a second from the watching thread. Counts before the previous call are ignored: page faults and
  // preemptions until then explain no later overrun. The cyclic thread makes no system calls for it.
  void watch_counts() { timing_.watch_counts(); }
  // Sign of life, for a watchdog.
  [[nodiscard]] const std::atomic<std::int64_t>& get_beats() const noexcept { return heartbeat_.get_beats(); }
  [[nodiscard]] std::string describe_place() const { return heartbeat_.describe_place(); }

 private:
  enum class Next { kStep, kStop };

  // Reason why the run cannot start, none if its clock has.
  std::optional<std::string> begin();

  // The cycle.
  Next await_tick() noexcept;
  Next wait_realtime() noexcept;
  Next wait_lockstep() noexcept;
  Next lose(Participant& participant) noexcept;
  Next pause(Participant& participant) noexcept;
  Next cycle() noexcept UNLATCH_NONBLOCKING;
  void apply_commands() noexcept UNLATCH_NONBLOCKING;
  template <class Take>
  void list_received(Take&& take) const noexcept;
  void begin_faults() noexcept;
  void publish(const StepReport& report) noexcept UNLATCH_NONBLOCKING;
  Next account(std::int64_t step_end_ns) noexcept UNLATCH_NONBLOCKING;
  Next account_overrun(std::int64_t now_ns) noexcept UNLATCH_NONBLOCKING;

  // The end.
  LogEnd conclude(RunStatus status, std::string message);
  LogEnd conclude_stop();

  [[nodiscard]] bool is_realtime() const noexcept { return options_.pace == Pace::kRealtime; }
  Next stop(std::string message) noexcept;

  const ExecutiveOptions options_;
  const Clock& clock_;
  Simulation& simulation_;
  Recorder& recorder_;

  Timing timing_;
  Heartbeat heartbeat_;
  Session session_;
  ChannelWriter channels_;
  HealthReporter health_;

  const std::unique_ptr<TickSource> own_ticks_;
  TickSource& ticks_;
  WarmUp warm_up_;
  TickTiming now_;                          // account of the present tick
  std::int64_t hash_ = 0;                   // hash of the present state
  std::optional<std::int64_t> applied_ns_;  // arrival of the latest command that was applied, until the next State
  StepReport last_report_;                  // report of the latest step
  bool overrun_ends_ = false;               // the run stops because of an overrun
  std::string end_message_;
  std::atomic<bool> stop_{false};
};

}  // namespace unlatch::hil
