#include "hil/executive_roster.h"

#include <algorithm>

namespace unlatch::hil {

bool SeenCommands::insert(std::int64_t sequence) noexcept {
  std::int64_t& latest = latest_[slot(sequence)];
  if (sequence <= latest) return false;
  latest = sequence;
  return true;
}

bool SeenCommands::has_all(std::int64_t last, std::int64_t count) const noexcept {
  count = std::min({count, last, static_cast<std::int64_t>(kWindow)});
  for (std::int64_t sequence = last; sequence > last - count; --sequence) {
    if (latest_[slot(sequence)] < sequence) return false;
  }
  return true;
}

Roster::Roster(const std::vector<std::string>& required) {
  participants_.reserve(std::max(kMaxParticipants, required.size()));
  for (const std::string& name : required) {
    Participant participant;
    participant.name = name;
    participant.required = true;
    participant.ack.tick = -1;
    participants_.push_back(participant);
  }
}

Participant* Roster::find(std::int32_t id) noexcept {
  for (Participant& participant : participants_) {
    if (participant.ready && participant.id == id) return &participant;
  }
  return nullptr;
}

Participant* Roster::admit(const HelloAck& hello) noexcept {
  const std::string_view name = get_name(hello.name);
  Participant* const known = find(hello.participant);
  if (known != nullptr) return known->name == name ? known : nullptr;
  for (Participant& participant : participants_) {
    if (participant.name != name) continue;
    if (participant.ready) return nullptr;  // a second one of that name
    participant.id = hello.participant;
    participant.ready = true;
    return &participant;
  }
  if (participants_.size() == participants_.capacity()) return nullptr;
  Participant& guest = participants_.emplace_back();
  guest.name = name;  // may allocate: guests are expected before the first tick, or seldom
  guest.id = hello.participant;
  guest.ready = true;
  guest.ack.tick = -1;
  return &guest;
}

bool Roster::is_complete() const noexcept {
  return std::all_of(participants_.begin(), participants_.end(),
                     [](const Participant& participant) { return participant.ready || !participant.required; });
}

std::string Roster::list_missing() const {
  std::string names;
  for (const Participant& participant : participants_) {
    if (participant.ready || !participant.required) continue;
    names += (names.empty() ? "'" : ", '") + participant.name + "'";
  }
  return names;
}

}  // namespace unlatch::hil
