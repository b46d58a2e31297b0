#include "hil/session/participants/participants.h"

#include <algorithm>
#include <utility>

namespace unlatch::hil {

using Standing = Participant::Standing;

Participants::Participants(const std::vector<std::string>& required) : required_count_(required.size()) {
  participants_.reserve(std::max(kMaxParticipants, required.size()));
  for (const std::string& name : required) {
    Participant participant;
    participant.name = name;
    participant.required = true;
    participant.ack.tick = -1;
    participants_.push_back(participant);
  }
  guest_names_.resize(participants_.capacity() - participants_.size());
  for (std::string& name : guest_names_) name.reserve(kNameLength);
}

Participant* Participants::find(std::int32_t id) noexcept {
  for (Participant& participant : participants_) {
    if (participant.standing != Standing::kAbsent && participant.id == id) return &participant;
  }
  return nullptr;
}

Participant* Participants::find(std::string_view name) noexcept {
  for (Participant& participant : participants_) {
    if (participant.name == name) return &participant;
  }
  return nullptr;
}

// A new start of a participant has sent nothing yet.
Admission Participants::begin(Participant& participant, const HelloAckMessage& hello, Admission how) noexcept {
  participant.standing = Standing::kPresent;
  participant.leaving = false;
  participant.id = hello.participant;
  participant.ack = StepAckMessage{};
  participant.ack.tick = -1;
  participant.waiting_since_ns.reset();
  participant.seen = SeenCommands{};
  participant.news_ns.reset();
  return how;
}

Admission Participants::admit(const HelloAckMessage& hello) noexcept {
  const std::string_view name = get_name(hello.name);
  const Participant* const same_id = find(hello.participant);
  if (same_id != nullptr && same_id->name != name) return Admission::kNameTaken;
  Participant* const known = find(name);
  if (known == nullptr) {
    if (guest_names_.empty()) return Admission::kFull;
    Participant& guest = participants_.emplace_back();
    guest.name = std::move(guest_names_.back());
    guest.name.assign(name);
    guest_names_.pop_back();
    return begin(guest, hello, Admission::kFirstStart);
  }
  switch (known->standing) {
    case Standing::kAbsent:
      return begin(*known, hello, Admission::kFirstStart);
    case Standing::kPresent:
      return same_id != nullptr ? Admission::kKnown : Admission::kNameTaken;
    case Standing::kLost:
      return same_id == nullptr ? begin(*known, hello, Admission::kNewStart) : Admission::kKnown;
    case Standing::kEvicted:
      break;
  }
  return Admission::kEvicted;
}

bool Participants::is_complete() const noexcept { return count_missing() == 0; }

std::int64_t Participants::count_missing() const noexcept {
  return std::count_if(participants_.begin(), participants_.end(), [](const Participant& participant) {
    return participant.required && !participant.is_present();
  });
}

}  // namespace unlatch::hil
