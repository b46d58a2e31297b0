// Messages that a run publishes: State, Event, Health, Verdict, Reactions. The publisher numbers them, sends them, and
// records those of a recording. Fixed memory.
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "hil/run/recording/recorder.h"
#include "hil/run/simulation/simulation.h"
#include "hil/session/faults/fault_injector.h"
#include "hil/session/messages/messages.h"
#include "hil/session/participants/connection.h"
#include "hil/session/realtime/timing_summary.h"

namespace unlatch::hil {

class Publisher {
 public:
  // `faults` distort sensor values; null for none. All must outlive it.
  Publisher(const Simulation& simulation, Recorder& recorder, Connection& connection, FaultInjector* faults,
            std::int64_t session);

  // Sends the State of the simulation's tick, all parts; records it if it is due or the run does not go on.
  void publish_state(RunStatus status, std::int64_t hash) noexcept;
  // Sends the State once more, with the same sequence number.
  void resend_state(RunStatus status) noexcept;

  // An event of the model that fired in the step to this tick.
  void publish_event(const FiredEvent& fired) noexcept;
  // An event of the session: a participant, a policy, a fault. take_notice() gives it to people as well.
  void publish_notice(std::string_view name, std::string_view subject) noexcept;
  // Notices of the faults that have begun, ended or hit a message since the last call.
  void publish_fault_notices() noexcept;
  void publish_overrun(const Overrun& overrun) noexcept;

  // Completes the message with session, sequence number, time and States resent.
  void publish_health(HealthMessage health) noexcept;
  // Sends the reactions of the latest step, all parts at once.
  void publish_reactions() noexcept;

  // The answer to a message that was refused, or late; recorded as an event. At most kVerdictsPerTick between two calls
  // of begin_tick(). `from`: name of the sender; empty if it is not known.
  void publish_verdict(Reject reason, std::string_view from, std::int32_t participant, std::int64_t refers_to,
                       std::int32_t channel, std::int64_t applied_tick) noexcept;
  // Asks a participant for commands that it announced and that have not arrived: `count` from `first` on. Not counted.
  void publish_missing(std::int32_t participant, std::int64_t first, std::int64_t count) noexcept;
  void begin_tick() noexcept { verdicts_left_ = kVerdictsPerTick; }

  // One other thread.
  [[nodiscard]] bool take_notice(EventMessage& event) noexcept { return notices_.try_dequeue(event); }

  [[nodiscard]] std::int64_t get_resent() const noexcept { return resent_; }
  void set_resent(std::int64_t count) noexcept { resent_ = count; }

  static constexpr int kVerdictsPerTick = 16;

 private:
  void send_state_part(std::int32_t part, RunStatus status) noexcept;
  void send_verdict(VerdictMessage verdict) noexcept;
  void record_verdict(Reject reason, std::string_view from, std::int32_t channel) noexcept;
  // `tick`: the step in which it happened.
  void publish(EventMessage& event, std::int64_t tick, double time) noexcept;

  const Simulation& simulation_;
  Recorder& recorder_;
  Connection& connection_;
  FaultInjector* const faults_;
  const std::int64_t session_, dt_ns_;
  const std::vector<EventMessage> model_events_;  // name and subject of each event

  StateMessage state_;          // scratch
  ReactionsMessage reactions_;  // scratch
  std::int64_t state_sequence_ = 0, event_sequence_ = 0, health_sequence_ = 0, verdict_sequence_ = 0,
               reactions_sequence_ = 0;
  int verdicts_left_ = kVerdictsPerTick;
  std::int64_t resent_ = 0;  // States
  moodycamel::BlockingReaderWriterCircularBuffer<EventMessage> notices_{256};
};

}  // namespace unlatch::hil
