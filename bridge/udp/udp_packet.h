// The datagrams of the UDP transport: a header and a message as LCM carries it. bridge/UDP.md describes them for
// authors of clients.
//
//   offset  bytes  (all numbers big-endian)
//    0      4      magic, 0x554e4c31: "UNL1"
//    4      4      run: a random number that the sender has chosen when it opened its socket
//    8      4      sequence: counts the sender's datagrams to this receiver from 0, modulo 2³²
//   12      2      kind: 0 join, else 1 + the message's number (MessageKind)
//   14      2      length of what follows the header, in bytes
//   16      4      checksum: CRC-32 (IEEE 802.3, as zlib.crc32) of the datagram with these four bytes zero
//   20      …      a message's fingerprint and fields; of a join its role, 4 bytes: 1 participant, 2 observer
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "bridge/core/port.h"

namespace unlatch::bridge {

inline constexpr std::size_t kUdpHeaderBytes = 20;
inline constexpr std::size_t kMaxUdpBytes = kUdpHeaderBytes + hil::kMaxWireBytes;

// CRC-32 of IEEE 802.3, to be continued from a previous result.
[[nodiscard]] std::uint32_t calc_crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) noexcept;

struct UdpHeader {
  std::uint32_t run = 0, sequence = 0;
};

// The content of a datagram; `payload` lies in it.
struct UdpPacket {
  UdpHeader header;
  std::optional<hil::MessageKind> kind;  // none: a join
  Role role = Role::kObserver;           // of a join
  std::span<const std::uint8_t> payload;
};

// Bytes of a message that encode() has written behind a free header: writes the header and returns the datagram's
// length.
std::size_t seal_udp_message(const UdpHeader& header, hil::MessageKind kind, std::span<std::uint8_t> datagram,
                             std::size_t message_bytes) noexcept;
// Writes a join. `datagram`: kUdpHeaderBytes + 4 at least.
std::size_t build_udp_join(const UdpHeader& header, Role role, std::span<std::uint8_t> datagram) noexcept;

// Nothing unless magic, kind, length and checksum are right. The message's own bytes are decode()'s to judge.
[[nodiscard]] std::optional<UdpPacket> read_udp_packet(std::span<const std::uint8_t> datagram) noexcept;

// What the first bytes of a stream of datagrams say (bridge/uart).
struct UdpBeginning {
  bool is_none;       // no datagram begins here
  std::size_t bytes;  // of the datagram; 0: too few are there to say
};
[[nodiscard]] UdpBeginning read_udp_beginning(std::span<const std::uint8_t> stream) noexcept;

// Order of one sender's datagrams: those that are late or come twice are refused, gaps are counted.
class UdpSequence {
 public:
  // False: late, or a repetition.
  bool accept(const UdpHeader& header) noexcept;
  [[nodiscard]] std::int64_t get_lost() const noexcept { return lost_; }

 private:
  std::optional<std::uint32_t> run_;
  std::uint32_t next_ = 0;
  std::int64_t lost_ = 0;
};

}  // namespace unlatch::bridge
