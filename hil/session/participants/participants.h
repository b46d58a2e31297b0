// Participants of a session: standing, latest answer and commands of each. Fixed memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/session/messages/messages.h"
#include "hil/session/participants/seen_commands.h"

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
  bool leaving = false;                          // has announced that it leaves; the policy is due
  std::int32_t id = 0;                           // number of its present start
  StepAckMessage ack;                            // latest answer; tick -1: none yet
  std::int64_t ack_arrived_ns = 0;               // arrival of `ack`, if there is one
  std::optional<std::int64_t> waiting_since_ns;  // since then it owes an answer; none: it owes none
  SeenCommands seen;
  std::optional<std::int64_t> news_ns;  // arrival of its latest new command

  [[nodiscard]] bool is_present() const noexcept { return standing == Standing::kPresent; }
  // True if it has answered `tick`, and every command that it announced has arrived.
  [[nodiscard]] bool has_answered(std::int64_t tick) const noexcept {
    return is_present() && ack.tick == tick && seen.has_all(ack.last_command, ack.command_count);
  }
};

enum class Admission {
  kKnown,       // introduced before; answers decide whether it is lost
  kFirstStart,  // first start of a participant in this session
  kNewStart,    // another start of one that was lost or had left
  kNameTaken,   // another start of that name takes part, or another participant has its number
  kEvicted,
  kFull,
};

class Participants {
 public:
  explicit Participants(const std::vector<std::string>& required);

  // Participant with that number, of any standing; null if there is none.
  [[nodiscard]] Participant* find(std::int32_t id) noexcept;
  [[nodiscard]] Participant* find(std::string_view name) noexcept;
  // Admits a participant that introduces itself.
  Admission admit(const HelloAckMessage& hello) noexcept;

  [[nodiscard]] std::vector<Participant>& all() noexcept { return participants_; }
  [[nodiscard]] const std::vector<Participant>& all() const noexcept { return participants_; }
  // Number of a participant in recordings: required ones from 0 in the scenario's order, then guests in the order
  // of their arrival.
  [[nodiscard]] std::int32_t get_index(const Participant& participant) const noexcept {
    return static_cast<std::int32_t>(&participant - participants_.data());
  }
  static constexpr std::size_t kMaxParticipants = 16;  // capacity, unless more are required
  [[nodiscard]] std::size_t get_required_count() const noexcept { return required_count_; }
  [[nodiscard]] std::size_t get_capacity() const noexcept { return participants_.capacity(); }
  [[nodiscard]] bool is_complete() const noexcept;            // true if every required participant is present
  [[nodiscard]] std::int64_t count_missing() const noexcept;  // required participants that are not present
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
