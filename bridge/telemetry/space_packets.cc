#include "bridge/telemetry/space_packets.h"

#include <algorithm>
#include <span>
#include <utility>

namespace unlatch::bridge {
namespace {

using Kind = hil::MessageKind;

constexpr std::uint16_t kCountMask = 0x3FFF;      // 14 bits
constexpr std::uint16_t kUnsegmented = 0xC000;    // sequence flags 11
constexpr std::uint16_t kSecondaryFlag = 0x0800;  // of telemetry (type 0), packet version number 0
constexpr std::size_t kFingerprint = 8;           // bytes before the fields on the wire
constexpr std::int64_t kNanosecond = 1'000'000'000;

void put(SpacePacket& packet, std::uint64_t number, int bytes) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
    packet.push_back(static_cast<std::uint8_t>(number >> shift));
}

int get_part(const hil::Message& message) {
  if (message.kind == Kind::kState) return message.state.part;
  return message.kind == Kind::kReactions ? message.reactions.part : 0;
}

std::int64_t get_session(const hil::Message& message) { return message.hello.session; }  // the first field of all

// The time of a message, or that of the latest one that has a time.
std::int64_t get_time(const hil::Message& message, std::int64_t latest) {
  switch (message.kind) {
    case Kind::kState:
      return message.state.time_ns;
    case Kind::kEvent:
      return message.event.time_ns;
    case Kind::kHealth:
      return message.health.time_ns;
    case Kind::kReactions:
      return message.reactions.time_ns;
    default:
      return latest;
  }
}

bool fits(const hil::Message& message, const SessionLayout& layout) {
  if (get_session(message) != layout.get_session()) return false;
  if (message.kind == Kind::kState) {
    const hil::StateMessage& state = message.state;
    const auto valid = [&](const char* field) {
      return static_cast<std::int32_t>(layout.count_valid(message.kind, field, state.part));
    };
    return layout.is_complete() && state.part < std::min(layout.count_state_parts(), kMostStateParts) &&
           state.body_count == valid("bodies") && state.sensor_count == valid("sensors") &&
           state.joint_count == valid("modes");
  }
  if (message.kind == Kind::kReactions)
    return layout.is_complete() && message.reactions.part < std::min(layout.count_reaction_parts(), kMostReactionParts);
  return true;
}

}  // namespace

bool is_sent(Kind kind) { return kind != Kind::kCatalog && kind != Kind::kSource && kind != Kind::kStepAck; }

int get_apid(Kind kind, int part) {
  if (kind == Kind::kState) return kStateApid + part;
  if (kind == Kind::kReactions) return kReactionsApid + part;
  return kFirstApid + static_cast<int>(kind);
}

bool SpacePacketWriter::write(const hil::Message& message, const SessionLayout& layout, SpacePacket& packet) {
  if (!is_sent(message.kind) || !fits(message, layout)) return false;
  if (encode(message, wire_) == 0) return false;
  if (std::exchange(session_, layout.get_session()) != layout.get_session()) time_ns_ = 0;
  time_ns_ = std::max<std::int64_t>(get_time(message, time_ns_), 0);
  const int part = get_part(message), apid = get_apid(message.kind, part);

  packet.clear();
  put(packet, kSecondaryFlag | static_cast<std::uint16_t>(apid), 2);
  std::uint16_t& count = counts_[static_cast<std::size_t>(apid)];
  put(packet, kUnsegmented | count, 2);
  put(packet, 0, 2);  // the length, below
  put(packet, static_cast<std::uint64_t>(time_ns_ / kNanosecond), 4);
  put(packet, (static_cast<std::uint64_t>(time_ns_ % kNanosecond) << 24U) / kNanosecond, 3);

  std::size_t from = kFingerprint;
  for (const MessageField& field : kMessageFields[static_cast<std::size_t>(message.kind)]) {
    const bool is_cut = field.count > 1 && (message.kind == Kind::kState || message.kind == Kind::kReactions);
    const std::size_t valid = is_cut ? layout.count_valid(message.kind, field.name, part) : field.count;
    const std::span<const std::uint8_t> bytes = std::span(wire_).subspan(from, valid * get_size(field));
    packet.insert(packet.end(), bytes.begin(), bytes.end());
    from += field.count * get_size(field);
  }
  const std::size_t length = packet.size() - kPrimaryHeader - 1;
  packet[4] = static_cast<std::uint8_t>(length >> 8U);
  packet[5] = static_cast<std::uint8_t>(length);
  count = static_cast<std::uint16_t>((count + 1) & kCountMask);
  return true;
}

}  // namespace unlatch::bridge
