// The participants of a session: which have introduced themselves, the latest answer of each, and the commands seen
// from each. Fixed memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/messages/messages.h"

namespace unlatch::hil {

// The latest command numbers of a participant that have arrived, in any order.
class SeenCommands {
 public:
  // False for a number that was seen already, or is too old to be known.
  bool insert(std::int64_t sequence) noexcept;
  // True if all `count` numbers up to `last` have been seen. Numbers older than the window count as seen.
  [[nodiscard]] bool has_all(std::int64_t last, std::int64_t count) const noexcept;

 private:
  static constexpr std::size_t kWindow = 1024;
  static std::size_t slot(std::int64_t sequence) noexcept { return static_cast<std::size_t>(sequence) % kWindow; }
  std::array<std::int64_t, kWindow> latest_{};  // the number last seen in each slot; numbers count from 1
};

struct Participant {
  enum class Standing {
    kAbsent,   // has not introduced itself, or has left as a guest
    kPresent,  // takes part
    kLost,     // the policy was applied; it may come back
    kEvicted,  // the policy was applied, and it may not
  };
  std::string name;
  bool required = false;
  Standing standing = Standing::kAbsent;
  bool leaving = false;  // it has announced that it leaves; the policy is due
  std::int32_t id = 0;   // of its present start
  StepAckMessage ack;    // the latest; tick -1: none yet
  std::int64_t ack_arrived_ns = 0;
  std::optional<std::int64_t> waiting_since_ns;  // time since which it owes an answer, if it owes one
  SeenCommands seen;

  [[nodiscard]] bool is_present() const noexcept { return standing == Standing::kPresent; }
  // It has answered `tick`, and every command that it announced has arrived.
  [[nodiscard]] bool has_answered(std::int64_t tick) const noexcept {
    return is_present() && ack.tick == tick && seen.has_all(ack.last_command, ack.command_count);
  }
};

enum class Admission {
  kKnown,       // that start of it introduced itself before; its answers decide whether it is lost
  kFirstStart,  // of a participant in this session
  kNewStart,    // a new start of one that was lost or had left
  kNameTaken,   // another start of that name takes part, or another participant has its number
  kEvicted,
  kFull,
};

class Participants {
 public:
  explicit Participants(const std::vector<std::string>& required);

  // Null if there is none with that number, of any standing.
  [[nodiscard]] Participant* find(std::int32_t id) noexcept;
  [[nodiscard]] Participant* find(std::string_view name) noexcept;
  // A participant introduces itself.
  Admission admit(const HelloAckMessage& hello) noexcept;

  [[nodiscard]] std::vector<Participant>& all() noexcept { return participants_; }
  // The number of a participant in recordings: required ones from 0 in the scenario's order, then guests in the order
  // of their arrival.
  [[nodiscard]] std::int32_t get_index(const Participant& participant) const noexcept {
    return static_cast<std::int32_t>(&participant - participants_.data());
  }
  [[nodiscard]] bool is_complete() const noexcept;            // every required participant is present
  [[nodiscard]] std::int64_t count_missing() const noexcept;  // required ones that are not
  // "'separation', 'guidance'": the required ones for which `wanted` holds. Allocates.
  template <class Wanted>
  [[nodiscard]] std::string list_required(Wanted&& wanted) const {
    std::string names;
    for (const Participant& participant : participants_) {
      if (!participant.required || !wanted(participant)) continue;
      names += (names.empty() ? "'" : ", '") + participant.name + "'";
    }
    return names;
  }

 private:
  static constexpr std::size_t kMaxParticipants = 16;
  static Admission begin(Participant& participant, const HelloAckMessage& hello, Admission how) noexcept;
  std::vector<Participant> participants_;  // required ones first; never grows beyond its reserved memory
  std::vector<std::string> guest_names_;   // memory for names of guests: one may join between two deadlines
};

}  // namespace unlatch::hil
