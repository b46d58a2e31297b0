// The participants of a session: which have introduced themselves, the latest answer of each, and the commands seen
// from each. Fixed memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/messages/messages.h"
#include "hil/session/seen_commands.h"

namespace unlatch::hil {

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
  bool leaving = false;                          // it has announced that it leaves; the policy is due
  std::int32_t id = 0;                           // of its present start
  StepAckMessage ack;                            // the latest; tick -1: none yet
  std::int64_t ack_arrived_ns = 0;               // of `ack`, if there is one
  std::optional<std::int64_t> waiting_since_ns;  // time since which it owes an answer, if it owes one
  SeenCommands seen;
  std::optional<std::int64_t> news_ns;  // arrival of its latest command that had not arrived before

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
  [[nodiscard]] const std::vector<Participant>& all() const noexcept { return participants_; }
  // The number of a participant in recordings: required ones from 0 in the scenario's order, then guests in the order
  // of their arrival.
  [[nodiscard]] std::int32_t get_index(const Participant& participant) const noexcept {
    return static_cast<std::int32_t>(&participant - participants_.data());
  }
  static constexpr std::size_t kMaxParticipants = 16;  // unless more are required
  [[nodiscard]] std::size_t get_required_count() const noexcept { return required_count_; }
  [[nodiscard]] std::size_t get_capacity() const noexcept { return participants_.capacity(); }
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
  static Admission begin(Participant& participant, const HelloAckMessage& hello, Admission how) noexcept;
  std::vector<Participant> participants_;  // required ones first; never grows beyond its reserved memory
  const std::size_t required_count_;
  std::vector<std::string> guest_names_;  // memory for names of guests: one may join between two deadlines
};

}  // namespace unlatch::hil
