// Faults of a script in action. They depend on the seed, the tick and the message alone, never on wall time or on the
// order of arrival. Fixed memory after construction; used by the cyclic thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hil/session/faults/fault_script.h"
#include "hil/session/participants/participants.h"

namespace unlatch::hil {

enum class Direction { kIn, kOut };

// Notice that a fault began, ended, or hit a message; to be published as an Event.
struct FaultNotice {
  std::string_view name;  // "fault.freeze", "fault.freeze.end", "fault.message.drop"
  const Fault* fault = nullptr;
};

class FaultInjector {
 public:
  // `sensor_values`: number of components of all sensors.
  explicit FaultInjector(const FaultScript& script, std::size_t sensor_values = 0);

  // Begins a tick: faults begin and end. `resume(participant)` is called for one whose freeze is over.
  template <class Resume>
  void begin_tick(std::int64_t tick, std::int64_t now_ns, Participants& participants, Resume&& resume) noexcept {
    tick_ = tick;
    attempts_.fill({});
    for (std::size_t i = 0; i < faults_.size(); ++i) {
      if (update(i, now_ns, participants)) resume(*participants.find(std::string_view(faults_[i].fault.participant)));
    }
  }
  // Ends freezes that are limited in wall time, also within a tick.
  template <class Resume>
  void end_timed_freezes(std::int64_t now_ns, Participants& participants, Resume&& resume) noexcept {
    for (Active& active : faults_) {
      if (!active.on || active.fault.time_ns == 0 || active.fault.kind != Fault::Kind::kFreeze) continue;
      if (now_ns - active.since_ns < active.fault.time_ns) continue;
      end(active);
      resume(*participants.find(std::string_view(active.fault.participant)));
    }
  }

  // Takes a message on its way; `from`: the participant that sends it. take() gives its result: the message, now or
  // later, once or several times, or nothing.
  void offer(Direction direction, const Message& message, std::int64_t arrived_ns, std::int64_t now_ns,
             std::string_view from) noexcept;
  bool take(Direction direction, std::int64_t now_ns, Message& message, std::int64_t& arrived_ns) noexcept;

  // Distorts sensors that stick or are biased, in a State that is about to be sent.
  void distort(StateMessage& state) noexcept;
  // Notes the sensor values of a State that is on its way to flight software now.
  void note_sent(const StateMessage& state) noexcept;
  // Sensor values of the latest State that has left, in the order of the model; NaN before the first.
  [[nodiscard]] std::span<const double> get_received() const noexcept { return received_; }
  // Value at which a fault holds a channel; none without a fault. `value`: its present value, at which it may jam.
  [[nodiscard]] std::optional<double> get_forced(std::size_t channel, double value) noexcept;

  bool take_notice(FaultNotice& notice) noexcept;
  [[nodiscard]] std::int64_t get_malformed() const noexcept { return malformed_; }  // corrupted beyond reading
  [[nodiscard]] std::int64_t get_dropped() const noexcept {
    return dropped_;
  }  // a queue was full, that of notices included
  struct Tally {
    const Fault* fault;
    std::int64_t count;  // messages that it hit
  };
  [[nodiscard]] std::vector<Tally> list_tallies() const;

 private:
  struct Active {
    Fault fault;
    std::string name, end_name;  // names of its Events
    bool on = false, over = false;
    std::int64_t since_ns = 0;
    std::int64_t hit_count = 0;    // messages
    std::int32_t id = 0;           // kill: number of the start that was killed
    std::vector<double> stuck;     // stick: the values, in the order of fault.values
    std::vector<bool> known;       // the value has been seen
    std::optional<double> jammed;  // jam: the value
  };
  struct Held {
    Message message;
    std::int64_t arrived_ns = 0;
    std::optional<std::int64_t> due_tick, due_ns;  // delayed: until then
    bool awaits_another = false;                   // reordered: until another has passed
  };
  struct Attempts {
    std::uint64_t message = 0;
    std::int32_t count = 0;
  };
  static constexpr std::size_t kCapacity = 512;

  // True if a freeze has just ended.
  bool update(std::size_t index, std::int64_t now_ns, Participants& participants) noexcept;
  void end(Active& active) noexcept;
  void notify(std::string_view name, const Active& active) noexcept;
  [[nodiscard]] bool is_muted(const Message& message, std::string_view from) const noexcept;
  [[nodiscard]] bool hits(std::size_t index, const Message& message, std::uint64_t draw,
                          std::string_view from) noexcept;
  std::int32_t count_attempt(std::uint64_t identity) noexcept;
  bool corrupt(Message& message, int bits, std::uint64_t seed) noexcept;

  const std::uint64_t seed_;
  std::vector<Active> faults_;
  std::int64_t tick_ = 0;
  std::array<std::vector<Held>, 2> held_;  // messages of each Direction
  std::array<Attempts, kCapacity> attempts_{};
  std::vector<double> received_;
  std::vector<FaultNotice> notices_;
  std::size_t taken_ = 0;  // notices already taken
  std::int64_t malformed_ = 0, dropped_ = 0;
};

}  // namespace unlatch::hil
