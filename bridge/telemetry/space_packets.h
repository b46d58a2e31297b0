// Messages as CCSDS space packets (CCSDS 133.0-B-2, Space Packet Protocol): telemetry, version 1, unsegmented, with a
// secondary header of the simulated time as an unsegmented time code (CCSDS 301.0-B-4, CUC: 4 octets of seconds, 3 of
// their fraction, epoch: the beginning of the run, without a P-field, which would be 0x2F).
//
// The user data are the fields of a message in the order of the schema, big-endian. Of State and Reactions, which are
// cut into parts, each part has an application process identifier of its own, and holds the valid entries alone: so
// every packet has one size and one meaning in a session, which its XTCE description (xtce.h) names.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bridge/telemetry/message_fields.h"
#include "bridge/telemetry/session_layout.h"

namespace unlatch::bridge {

using SpacePacket = std::vector<std::uint8_t>;

inline constexpr std::size_t kPrimaryHeader = 6, kSecondaryHeader = 7;  // bytes
// Application process identifiers: one for each kind of message, and one for each part of State and of Reactions.
inline constexpr int kFirstApid = 100, kStateApid = 200, kReactionsApid = 1200, kLastApid = 2046;
// Parts of State and Reactions beyond these have no packets: 16,000 bodies, 27,000 joints.
inline constexpr int kMostStateParts = kReactionsApid - kStateApid, kMostReactionParts = kLastApid - kReactionsApid + 1;

// True for kinds that become packets: all but the source and what only concerns the session's members.
[[nodiscard]] bool is_sent(hil::MessageKind kind);
[[nodiscard]] int get_apid(hil::MessageKind kind, int part);

class SpacePacketWriter {
 public:
  // Writes the packet of a message of the session; false, and nothing is written, if it has none, or the layout does
  // not fit. `packet` keeps its memory.
  bool write(const hil::Message& message, const SessionLayout& layout, SpacePacket& packet);

 private:
  std::int64_t session_ = 0, time_ns_ = 0;  // time of the session's latest message that has one, for those without
  std::array<std::uint16_t, kLastApid + 1> counts_{};
  std::array<std::uint8_t, hil::kMaxWireBytes> wire_{};
};

}  // namespace unlatch::bridge
