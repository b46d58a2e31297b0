#include "hil/session/faults/fault_injector.h"

#include <algorithm>
#include <limits>

#include "hil/session/messages/event_names.h"

namespace unlatch::hil {
namespace {

using Kind = Fault::Kind;

// Name of the Event when a fault of this kind begins or hits a message.
std::string make_event_name(const Fault& fault) {
  const std::string_view prefix = fault.is_of_messages() ? kMessageFaultPrefix : kFaultPrefix;
  return std::string(prefix) + kFaultNames[static_cast<std::size_t>(fault.kind)];
}

// splitmix64: next number of a pseudo-random sequence.
std::uint64_t mix(std::uint64_t seed, std::uint64_t value) noexcept {
  std::uint64_t bits = seed + 0x9e3779b97f4a7c15U * (value + 1);
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebU;
  return bits ^ (bits >> 31);
}

std::uint64_t mix(std::uint64_t seed, std::string_view text) noexcept {
  for (const char c : text) seed = mix(seed, static_cast<unsigned char>(c));
  return seed;
}

std::int32_t get_id(const Message& message) noexcept {
  switch (message.kind) {
    case MessageKind::kHelloAck:
      return message.hello_ack.participant;
    case MessageKind::kCommand:
      return message.command.participant;
    default:
      return message.step_ack.participant;
  }
}

// Identity of a message, which its repetitions share: kind, sender, number. Not the number that a participant draws
// at random when it starts.
std::uint64_t calc_identity(const Message& message, std::string_view from) noexcept {
  std::uint64_t identity = mix(mix(0, static_cast<std::uint64_t>(message.kind)), from);
  const auto add = [&identity](std::int64_t value) { identity = mix(identity, static_cast<std::uint64_t>(value)); };
  switch (message.kind) {
    case MessageKind::kState:
      add(message.state.tick);
      add(message.state.part);
      break;
    case MessageKind::kStepAck:
      add(message.step_ack.tick);
      break;
    default:
      add(message.hello.sequence);  // every message has session and sequence at the same place
  }
  return identity;
}

}  // namespace

FaultInjector::FaultInjector(const FaultScript& script, std::size_t sensor_values)
    : seed_(script.seed), received_(sensor_values, std::numeric_limits<double>::quiet_NaN()) {
  for (const Fault& fault : script.faults) {
    Active& active = faults_.emplace_back();
    active.fault = fault;
    active.name = make_event_name(fault);
    active.end_name = active.name + ".end";
    active.stuck.resize(fault.values.size());
    active.known.resize(fault.values.size());
  }
  for (std::vector<Held>& held : held_) held.reserve(kCapacity);
  notices_.reserve(kCapacity);
}

// --- Beginnings and ends --------------------------------------------------------------------------------------------

void FaultInjector::notify(std::string_view name, const Active& active) noexcept {
  if (taken_ == notices_.size()) {
    notices_.clear();
    taken_ = 0;
  }
  if (notices_.size() == kCapacity) {
    ++dropped_;
    return;
  }
  notices_.push_back({name, &active.fault});
}

bool FaultInjector::take_notice(FaultNotice& notice) noexcept {
  if (taken_ == notices_.size()) return false;
  notice = notices_[taken_++];
  return true;
}

void FaultInjector::end(Active& active) noexcept {
  active.on = false;
  active.over = true;
  notify(active.end_name, active);
}

bool FaultInjector::update(std::size_t index, std::int64_t now_ns, Participants& participants) noexcept {
  Active& active = faults_[index];
  const Fault& fault = active.fault;
  if (fault.is_of_messages() || active.over) return false;
  const Participant* const participant =
      fault.participant.empty() ? nullptr : participants.find(std::string_view(fault.participant));
  if (!fault.participant.empty() && participant == nullptr) return false;  // pace fast: there are no participants
  if (!active.on && fault.is_at(tick_)) {
    active.on = true;
    active.since_ns = now_ns;
    if (participant != nullptr && fault.kind == Kind::kKill) active.id = participant->id;
    notify(active.name, active);
  } else if (active.on && tick_ > fault.last_tick && fault.kind != Kind::kKill) {
    end(active);
    return fault.kind == Kind::kFreeze;
  }
  return false;
}

// --- Messages -------------------------------------------------------------------------------------------------------

// True for messages of a participant that is frozen, or of a start that was killed.
bool FaultInjector::is_muted(const Message& message, std::string_view from) const noexcept {
  return std::any_of(faults_.begin(), faults_.end(), [&](const Active& active) {
    if (!active.on || active.fault.participant != from) return false;
    return active.fault.kind == Kind::kFreeze || (active.fault.kind == Kind::kKill && active.id == get_id(message));
  });
}

// Number of times that this message was sent before at this tick.
std::int32_t FaultInjector::count_attempt(std::uint64_t identity) noexcept {
  for (std::size_t i = 0; i < attempts_.size(); ++i) {
    Attempts& attempts = attempts_[(identity + i) % attempts_.size()];
    if (attempts.count == 0) attempts.message = identity;
    if (attempts.message == identity) return attempts.count++;
  }
  return 0;
}

bool FaultInjector::hits(std::size_t index, const Message& message, std::uint64_t draw,
                         std::string_view from) noexcept {
  Active& active = faults_[index];
  const Fault& fault = active.fault;
  if (!fault.is_of_messages() || fault.message != message.kind || !fault.is_at(tick_)) return false;
  if (!fault.participant.empty() && fault.participant != from) return false;
  if (active.hit_count >= fault.count) return false;
  constexpr double kUnit = 0x1p-53;
  const std::uint64_t bits = mix(mix(seed_, index), draw);
  if (static_cast<double>(bits >> 11) * kUnit >= fault.probability) return false;
  ++active.hit_count;
  notify(active.name, active);
  return true;
}

// Flips bits of the encoded message, fingerprint included. False if it cannot be read any more.
bool FaultInjector::corrupt(Message& message, int bits, std::uint64_t seed) noexcept {
  std::array<std::uint8_t, kMaxWireBytes> bytes;
  const std::size_t length = encode(message, bytes);
  for (int i = 0; i < bits; ++i) {
    const std::uint64_t bit = mix(seed, static_cast<std::uint64_t>(i)) % (length * 8);
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
  }
  return decode(message.kind, std::span(bytes).first(length), message) && is_well_formed(message);
}

void FaultInjector::offer(Direction direction, const Message& message, std::int64_t arrived_ns, std::int64_t now_ns,
                          std::string_view from) noexcept {
  if (direction == Direction::kIn && is_muted(message, from)) return;
  const std::uint64_t identity = calc_identity(message, from);
  const std::uint64_t draw = mix(identity, static_cast<std::uint64_t>(count_attempt(identity)));
  std::vector<Held>& held = held_[static_cast<std::size_t>(direction)];
  Held next{message, arrived_ns, {}, {}, false};
  int copies = 1;
  for (std::size_t i = 0; i < faults_.size(); ++i) {
    if (!hits(i, message, draw, from)) continue;
    const Fault& fault = faults_[i].fault;
    if (fault.kind == Kind::kDrop) return;
    if (fault.kind == Kind::kDelay && fault.delay_ticks > 0) next.due_tick = tick_ + fault.delay_ticks;
    if (fault.kind == Kind::kDelay && fault.time_ns > 0) next.due_ns = now_ns + fault.time_ns;
    if (fault.kind == Kind::kDuplicate) copies += fault.copies;
    if (fault.kind == Kind::kReorder) next.awaits_another = true;
    if (fault.kind == Kind::kCorrupt && !corrupt(next.message, fault.bits, mix(draw, i))) {
      if (direction == Direction::kIn) ++malformed_;
      return;
    }
  }
  for (int i = 0; i < copies; ++i) {
    if (held.size() == kCapacity) {
      ++dropped_;
      return;
    }
    held.push_back(next);
  }
  if (next.awaits_another || held.size() == 1) return;
  // This message has overtaken those that were to be reordered.
  auto end = held.end();
  for (auto one = held.begin(); one != end;) {
    if (!one->awaits_another) {
      ++one;
      continue;
    }
    one->awaits_another = false;
    std::rotate(one, one + 1, held.end());
    --end;
  }
}

bool FaultInjector::take(Direction direction, std::int64_t now_ns, Message& message,
                         std::int64_t& arrived_ns) noexcept {
  std::vector<Held>& held = held_[static_cast<std::size_t>(direction)];
  for (auto one = held.begin(); one != held.end(); ++one) {
    if (one->awaits_another || one->due_tick.value_or(tick_) > tick_ || one->due_ns.value_or(now_ns) > now_ns) continue;
    message = one->message;
    const bool delayed = one->due_tick || one->due_ns;
    arrived_ns = delayed ? now_ns : one->arrived_ns;
    held.erase(one);
    return true;
  }
  return false;
}

// --- Sensors and actuators ------------------------------------------------------------------------------------------

void FaultInjector::distort(StateMessage& state) noexcept {
  const int first = state.part * static_cast<int>(kSensorsPerPart);
  for (Active& active : faults_) {
    if (!active.on || (active.fault.kind != Kind::kStick && active.fault.kind != Kind::kBias)) continue;
    for (std::size_t i = 0; i < active.fault.values.size(); ++i) {
      const int at = active.fault.values[i] - first;
      if (at < 0 || at >= state.sensor_count) continue;
      double& value = state.sensors[static_cast<std::size_t>(at)];
      if (active.fault.kind == Kind::kBias) {
        value += active.fault.offset;
        continue;
      }
      if (!active.known[i]) active.stuck[i] = value;
      active.known[i] = true;
      value = active.stuck[i];
    }
  }
}

void FaultInjector::note_sent(const StateMessage& state) noexcept {
  if (state.part < 0) return;
  const std::size_t first = static_cast<std::size_t>(state.part) * kSensorsPerPart;
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.sensor_count) && first + i < received_.size(); ++i)
    received_[first + i] = state.sensors[i];
}

std::optional<double> FaultInjector::get_forced(std::size_t channel, double value) noexcept {
  for (Active& active : faults_) {
    if (!active.on || active.fault.channel != static_cast<int>(channel)) continue;
    if (active.fault.kind == Kind::kDead) return 0.0;
    if (!active.jammed) active.jammed = value;
    return active.jammed;
  }
  return std::nullopt;
}

std::vector<FaultInjector::Tally> FaultInjector::list_tallies() const {
  std::vector<Tally> tallies;
  for (const Active& active : faults_) {
    if (active.fault.is_of_messages()) tallies.push_back({&active.fault, active.hit_count});
  }
  return tallies;
}

}  // namespace unlatch::hil
