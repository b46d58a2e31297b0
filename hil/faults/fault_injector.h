// Makes the faults of a script happen, between the executive and its line: there every transport is alike, and what
// happens depends on the seed, the tick and the message alone, never on wall time or on the order of arrival. Fixed
// memory after construction; used by the cyclic thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hil/faults/fault_script.h"
#include "hil/session/roster.h"

namespace unlatch::hil {

enum class Direction { kIn, kOut };

// Something to tell: a fault began, ended, or befell a message.
struct FaultNews {
  std::string_view name;  // "fault.freeze", "fault.freeze.end", "fault.message.drop"
  const Fault* fault = nullptr;
};

class FaultInjector {
 public:
  explicit FaultInjector(const FaultScript& script);

  // A tick begins: faults begin and end. `resume(participant)` is called for one whose freeze is over.
  template <class Resume>
  void begin_tick(std::int64_t tick, std::int64_t now_ns, Roster& roster, Resume&& resume) noexcept {
    tick_ = tick;
    attempts_.fill({});
    for (std::size_t i = 0; i < faults_.size(); ++i) {
      if (update(i, now_ns, roster)) resume(*roster.find(std::string_view(faults_[i].fault.participant)));
    }
  }
  // A freeze may also end while the tick stands still.
  template <class Resume>
  void look_at_clock(std::int64_t now_ns, Roster& roster, Resume&& resume) noexcept {
    for (Active& active : faults_) {
      if (!active.on || active.fault.time_ns == 0 || active.fault.kind != Fault::Kind::kFreeze) continue;
      if (now_ns - active.since_ns < active.fault.time_ns) continue;
      end(active);
      resume(*roster.find(std::string_view(active.fault.participant)));
    }
  }

  // A message on its way; `from`: the participant that says it. What comes of it, if anything and when, take() tells.
  void offer(Direction direction, const Message& message, std::int64_t arrived_ns, std::int64_t now_ns,
             std::string_view from) noexcept;
  bool take(Direction direction, std::int64_t now_ns, Message& message, std::int64_t& arrived_ns) noexcept;

  // Sensors that stick or are biased, in a State that is about to be said.
  void distort(State& state) noexcept;
  // The value that a fault holds a channel at, if one does; `value`: what it has now, at which it may jam.
  [[nodiscard]] std::optional<double> get_forced(std::size_t channel, double value) noexcept;

  bool take_news(FaultNews& news) noexcept;
  [[nodiscard]] std::int64_t get_malformed() const noexcept { return malformed_; }  // corrupted beyond reading
  [[nodiscard]] std::int64_t get_dropped() const noexcept { return dropped_; }      // found no room, news included
  struct Tally {
    const Fault* fault;
    std::int64_t count;  // messages that it befell
  };
  [[nodiscard]] std::vector<Tally> list_tallies() const;

 private:
  struct Active {
    Fault fault;
    bool on = false, over = false;
    std::int64_t since_ns = 0;
    std::int64_t befallen = 0;     // messages
    std::int32_t id = 0;           // kill: of the start that was killed
    std::vector<double> stuck;     // stick: the values, in the order of fault.values
    std::vector<bool> known;       // and whether they have been seen yet
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
  static constexpr std::size_t kRoom = 512;

  // True when a freeze has just ended.
  bool update(std::size_t index, std::int64_t now_ns, Roster& roster) noexcept;
  void end(Active& active) noexcept;
  void tell(std::string_view name, const Active& active) noexcept;
  [[nodiscard]] bool is_muted(const Message& message, std::string_view from) const noexcept;
  [[nodiscard]] bool befalls(std::size_t index, const Message& message, std::uint64_t draw,
                             std::string_view from) noexcept;
  std::int32_t count_attempt(std::uint64_t identity) noexcept;
  bool corrupt(Message& message, int bits, std::uint64_t seed) noexcept;

  const std::uint64_t seed_;
  std::vector<Active> faults_;
  std::int64_t tick_ = 0;
  std::array<std::vector<Held>, 2> held_;  // by direction
  std::array<Attempts, kRoom> attempts_{};
  std::vector<FaultNews> news_;
  std::size_t told_ = 0;
  std::int64_t malformed_ = 0, dropped_ = 0;
};

}  // namespace unlatch::hil
