// Who takes part in a session: which participants have introduced themselves, what each has answered, and which of its
// commands have been seen. Fixed memory.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hil/messages.h"

namespace unlatch::hil {

// Which of a participant's latest command numbers have arrived, in whatever order.
class SeenCommands {
 public:
  // False for a number that was seen already, or is so old that this cannot be told.
  bool insert(std::int64_t sequence) noexcept;
  // Have all `count` numbers up to `last` been seen? Counts beyond the window cannot be told and are taken as seen.
  [[nodiscard]] bool has_all(std::int64_t last, std::int64_t count) const noexcept;

 private:
  static constexpr std::size_t kWindow = 1024;
  static std::size_t slot(std::int64_t sequence) noexcept { return static_cast<std::size_t>(sequence) % kWindow; }
  std::array<std::int64_t, kWindow> latest_{};  // the number last seen in each slot; numbers count from 1
};

struct Participant {
  std::string name;
  bool required = false;
  bool ready = false;  // has introduced itself
  bool lost = false;   // the policy was applied; it takes no further part
  std::int32_t id = 0;
  StepAck ack;  // the latest
  std::int64_t ack_arrived_ns = 0;
  std::int64_t waiting_since_ns = -1;  // wall time since which it owes an answer; -1: it owes none
  SeenCommands seen;

  // It has answered `tick`, and every command that it announced has arrived.
  [[nodiscard]] bool has_answered(std::int64_t tick) const noexcept {
    return ready && ack.tick == tick && seen.has_all(ack.last_command, ack.command_count);
  }
};

class Roster {
 public:
  explicit Roster(const std::vector<std::string>& required);

  // Null if there is no such participant, or it has not introduced itself.
  [[nodiscard]] Participant* find(std::int32_t id) noexcept;
  // A participant introduces itself. Null when it is refused: its id is another's, or there is no room.
  Participant* admit(const HelloAck& hello) noexcept;

  [[nodiscard]] std::vector<Participant>& all() noexcept { return participants_; }
  [[nodiscard]] bool is_complete() const noexcept;  // every required participant is ready
  // "'separation', 'guidance'": the required ones that are not ready. Allocates.
  [[nodiscard]] std::string list_missing() const;

 private:
  static constexpr std::size_t kMaxParticipants = 16;
  std::vector<Participant> participants_;  // required ones first; never grows beyond what it was given room for
};

}  // namespace unlatch::hil
