// The cyclic executive: steps a simulation at its pace, with flight software in the loop, and accounts for every tick.
//
//   real time  wait for the tick → drain the command ring → step → push the state → account for the time
//              (with a spin before each tick: sleep → rehearse the step → wait awake)
//   lockstep   push the state → wait until every required participant has answered → step
//   fast       step
//
// In the loop: no allocation, lock, file or logging; it speaks to the outside through a Line and a Recorder alone (in
// real time the line is a Link; in lockstep, which has no deadline to miss, it may lead to the middleware itself). Wall
// time decides whether a participant is alive, simulated time everything else. When a required participant does not
// answer within its limit, the scenario's policy is applied and recorded, and the run goes on without it until it comes
// back (hold, zero, safe) or for good (evict), waits for it (pause) or ends (abort). The protocol: hil/PROTOCOL.md.
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hil/faults/fault_injector.h"
#include "hil/messages/line.h"
#include "hil/realtime/clock.h"
#include "hil/realtime/executive_timing.h"
#include "hil/realtime/nonblocking.h"
#include "hil/realtime/tick_source.h"
#include "hil/recording/recorder.h"
#include "hil/scenario/scenario.h"
#include "hil/session/command_queue.h"
#include "hil/session/roster.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

struct ExecutiveOptions {
  Pace pace = Pace::kLockstep;
  std::int64_t session = 0;
  std::int64_t last_tick = 0;  // the run ends there
  FlightSoftware flight_software;
  TimingOptions timing;
  FaultInjector* faults = nullptr;                 // what goes wrong on purpose; null for nothing
  std::vector<Source> source = {};                 // the scenario, for observers; empty: not told
  TickSource* ticks = nullptr;                     // real time: what paces it; null for the monotonic clock
  const Clock* clock = &kMonotonicClock;           // all times below and in messages
  std::int64_t start_timeout_ns = 20'000'000'000;  // for all required participants to introduce themselves
  std::int64_t resend_ns = 20'000'000;             // lockstep: a State without an answer is sent again
  std::int64_t announce_ns =
      10'000'000;  // one message of Hello and the catalog in turn, one of the source, while it runs
};

class Executive {
 public:
  // All must outlive the executive. `scenario` is the name told to participants.
  Executive(Simulation& simulation, Line& link, Recorder& recorder, const std::string& scenario,
            const ExecutiveOptions& options);

  // From the introductions to the end, on the calling thread.
  [[nodiscard]] LogEnd run();

  // From any thread, or a signal handler: the run ends, as aborted, within a tick or some milliseconds.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  // For one watching thread.
  [[nodiscard]] std::int64_t get_tick() const noexcept { return tick_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool take_notice(Event& event) noexcept { return notices_.try_dequeue(event); }
  // The watching thread, once a second or so: what befell the cyclic thread before the last time explains no later
  // overrun (without it: before the last overrun). Not for the cyclic thread, which makes no system calls for it.
  void watch_counts();
  // For a watchdog: changes as long as the cyclic thread lives; and what it is doing, "in the step of tick 412".
  [[nodiscard]] const std::atomic<std::int64_t>& get_beats() const noexcept { return beats_; }
  [[nodiscard]] std::string describe_place() const;

 private:
  enum class Go { kStep, kStop };
  enum class Place : std::int32_t { kBeginning, kWaiting, kHearing, kStepping, kSpeaking, kEnding };

  // executive.cc: one tick
  Go await_tick() noexcept;
  void rehearse(std::int64_t left_ns) noexcept UNLATCH_NONBLOCKING;
  Go cycle() noexcept UNLATCH_NONBLOCKING;
  void speak(const StepReport& report) noexcept UNLATCH_NONBLOCKING;
  Go account(std::int64_t step_end_ns) noexcept UNLATCH_NONBLOCKING;
  Go account_overrun(std::int64_t now_ns) noexcept UNLATCH_NONBLOCKING;
  void beat(Place place) noexcept {
    place_.store(place, std::memory_order_relaxed);
    beats_.fetch_add(1, std::memory_order_relaxed);
  }
  LogEnd conclude_stop();

  // executive_session.cc: the beginning, the end, and what is said
  bool introduce(std::string& failure);
  bool wait_for_introductions(std::int64_t deadline_ns);
  bool configure(std::string& failure);
  void say_hello();
  void announce(std::int64_t now_ns) noexcept;
  void announce_source() noexcept;
  void tell_rest_of_source();
  bool send_until_taken(const Message& message);
  void say(const Message& message) noexcept;
  void publish_state(RunStatus status) noexcept;
  void resend_state(RunStatus status) noexcept;
  void publish_event(Event event, double time, bool notice) noexcept;
  void publish_notice(std::string_view what, std::string_view subject) noexcept;
  void publish_overrun(const Overrun& overrun) noexcept;
  void publish_health(std::int64_t now_ns) noexcept;
  void publish_reactions(std::int64_t now_ns) noexcept;
  void publish_verdict(Reject reason, std::int32_t participant, std::int64_t refers_to, std::int32_t channel,
                       std::int64_t applied_tick) noexcept;
  [[nodiscard]] std::int64_t calc_dropped() const noexcept;
  LogEnd conclude(RunStatus status, std::string message);

  // executive_faults.cc: what goes wrong on purpose
  void begin_faults() noexcept;
  void pass_through_faults() noexcept;
  void force_channels() noexcept;
  void tell_faults() noexcept;
  [[nodiscard]] std::string_view find_speaker(const Message& message) noexcept;

  // executive_inputs.cc: what is heard, and when it is time to step
  Go wait_realtime() noexcept;
  Go wait_lockstep() noexcept;
  Go pause(Participant& participant) noexcept;
  void drain() noexcept UNLATCH_NONBLOCKING;
  void hear(const Message& message, std::int64_t arrived_ns) noexcept;
  void hear_hello(const HelloAck& hello) noexcept;
  void hear_command(const Command& command, std::int64_t arrived_ns) noexcept;
  void hear_ack(const StepAck& ack, std::int64_t arrived_ns) noexcept;
  void refuse(const HelloAck& hello, Reject reason, std::string_view notice) noexcept;
  void resume(Participant& participant) noexcept;
  [[nodiscard]] std::string_view find_mismatch(const HelloAck& hello) const noexcept;
  bool is_answered() noexcept;
  [[nodiscard]] Participant* find_overdue(std::int64_t now_ns) noexcept;
  [[nodiscard]] Go lose(Participant& participant) noexcept;
  void apply_policy(const Participant& participant) noexcept UNLATCH_NONBLOCKING;
  void apply_commands() noexcept;
  void set_channel(std::int32_t channel, double value, ChangeCause cause, std::int32_t participant,
                   std::int64_t sequence) noexcept;

  Simulation& simulation_;
  Line& link_;
  Recorder& recorder_;
  const ExecutiveOptions options_;
  const Clock& clock_;
  const std::int64_t dt_ns_;
  const std::int64_t timeout_ns_;
  Hello hello_;
  std::vector<Catalog> catalog_;
  std::vector<Source> source_;
  std::vector<Event> model_events_;  // name and subject of each

  Roster roster_;
  CommandDesk desk_;
  std::vector<const Participant*> commander_;  // of each channel: who set it last, or null
  std::vector<double> commanded_;              // what each channel would have without faults
  std::string refusal_;                        // before the first tick: why a required participant will not take part
  std::string end_message_;

  const std::unique_ptr<TickSource> own_ticks_;
  TickSource* const ticks_;
  Timing timing_;
  TickTiming now_;             // the tick that is being made
  StepReport last_report_;     // why the run stops, if it was the step
  bool overrun_ends_ = false;  // why the run stops, if it was an overrun
  std::int64_t slipped_ns_ = 0, skipped_outputs_ = 0;
  Message message_;                           // scratch
  Message spoken_;                            // scratch
  State state_;                               // scratch
  Reactions reactions_;                       // scratch
  std::int64_t rehearsal_ns_ = 0;             // how long the latest took
  std::optional<std::int64_t> rehearsed_ns_;  // when the last rehearsal ended
  std::int64_t hash_ = 0;
  std::int64_t state_sequence_ = 0, event_sequence_ = 0, catalog_sequence_ = 0, health_sequence_ = 0,
               verdict_sequence_ = 0, reactions_sequence_ = 0, source_sequence_ = 0;
  std::int64_t sent_ns_ = 0;                      // when the latest State went out
  std::int64_t sent_tick_ = 0;                    // and its tick
  bool round_trip_open_ = false;                  // it has not been answered by all yet
  std::int64_t heard_ns_ = 0;                     // when the latest command arrived; set before it is read
  std::optional<std::int64_t> applied_since_ns_;  // arrival of the latest command that no State has followed yet
  std::optional<std::int64_t> started_ns_, health_ns_, reactions_ns_;
  std::int64_t cutoff_ns_ = 0;                // real time: commands that arrive later are for the next tick
  std::optional<std::int64_t> announced_ns_;  // when announce() last spoke
  std::size_t announce_next_ = 0;             // 0: Hello, then the catalog
  std::size_t source_next_ = 0;               // part of the source whose turn it is
  std::optional<std::int32_t> refused_id_;    // of the latest HelloAck that was refused, so that each is told once
  int verdicts_left_ = 0;                     // that may still be told at this tick
  std::int64_t malformed_ = 0;                // of the line, already counted
  std::int64_t resent_ = 0;

  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> tick_{0}, beats_{0};
  std::atomic<Place> place_{Place::kBeginning};
  std::atomic<pid_t> thread_{0};  // that runs
  ThreadCounts watched_;          // watching thread
  moodycamel::BlockingReaderWriterCircularBuffer<Event> notices_{256};
};

}  // namespace unlatch::hil
