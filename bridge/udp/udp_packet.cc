#include "bridge/udp/udp_packet.h"

#include <algorithm>
#include <array>

namespace unlatch::bridge {
namespace {

constexpr std::uint32_t kMagic = 0x554e4c31;
constexpr std::size_t kRunAt = 4, kSequenceAt = 8, kKindAt = 12, kLengthAt = 14, kChecksumAt = 16;
constexpr std::size_t kJoinBytes = 4;
constexpr std::uint32_t kJoinParticipant = 1, kJoinObserver = 2;

constexpr std::array<std::uint32_t, 256> build_table() {
  constexpr std::uint32_t kPolynomial = 0xedb88320;  // reflected
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value & 1U) != 0 ? value >> 1U ^ kPolynomial : value >> 1U;
    table[i] = value;
  }
  return table;
}

constexpr std::array<std::uint32_t, 256> kTable = build_table();

void put(std::span<std::uint8_t> to, std::size_t at, std::uint32_t value, std::size_t bytes) noexcept {
  for (std::size_t i = bytes; i-- > 0; value >>= 8U) to[at + i] = static_cast<std::uint8_t>(value);
}

std::uint32_t get(std::span<const std::uint8_t> from, std::size_t at, std::size_t bytes) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + bytes; ++i) value = value << 8U | from[i];
  return value;
}

// Checksum of the datagram, computed as if its field for the checksum were zero.
std::uint32_t calc_checksum(std::span<const std::uint8_t> datagram) noexcept {
  constexpr std::array<std::uint8_t, kUdpHeaderBytes - kChecksumAt> kZero{};
  const std::uint32_t before = calc_crc32(datagram.first(kChecksumAt));
  return calc_crc32(datagram.subspan(kUdpHeaderBytes), calc_crc32(kZero, before));
}

std::size_t seal(const UdpHeader& header, std::uint32_t kind, std::span<std::uint8_t> datagram,
                 std::size_t payload) noexcept {
  const std::size_t length = kUdpHeaderBytes + payload;
  put(datagram, 0, kMagic, 4);
  put(datagram, kRunAt, header.run, 4);
  put(datagram, kSequenceAt, header.sequence, 4);
  put(datagram, kKindAt, kind, 2);
  put(datagram, kLengthAt, static_cast<std::uint32_t>(payload), 2);
  put(datagram, kChecksumAt, calc_checksum(datagram.first(length)), 4);
  return length;
}

}  // namespace

std::uint32_t calc_crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) noexcept {
  crc = ~crc;
  for (const std::uint8_t byte : bytes) crc = kTable[(crc ^ byte) & 0xFFU] ^ (crc >> 8U);
  return ~crc;
}

std::size_t seal_udp_message(const UdpHeader& header, hil::MessageKind kind, std::span<std::uint8_t> datagram,
                             std::size_t message_bytes) noexcept {
  return seal(header, 1 + static_cast<std::uint32_t>(kind), datagram, message_bytes);
}

std::size_t build_udp_join(const UdpHeader& header, Role role, std::span<std::uint8_t> datagram) noexcept {
  put(datagram, kUdpHeaderBytes, role == Role::kParticipant ? kJoinParticipant : kJoinObserver, kJoinBytes);
  return seal(header, 0, datagram, kJoinBytes);
}

std::optional<UdpPacket> read_udp_packet(std::span<const std::uint8_t> datagram) noexcept {
  if (datagram.size() < kUdpHeaderBytes || get(datagram, 0, 4) != kMagic) return std::nullopt;
  if (get(datagram, kLengthAt, 2) != datagram.size() - kUdpHeaderBytes) return std::nullopt;
  if (get(datagram, kChecksumAt, 4) != calc_checksum(datagram)) return std::nullopt;
  UdpPacket packet;
  packet.header = {.run = get(datagram, kRunAt, 4), .sequence = get(datagram, kSequenceAt, 4)};
  packet.payload = datagram.subspan(kUdpHeaderBytes);
  const std::uint32_t kind = get(datagram, kKindAt, 2);
  if (kind > hil::kMessageKinds) return std::nullopt;
  if (kind > 0) {
    packet.kind = static_cast<hil::MessageKind>(kind - 1);
    return packet;
  }
  if (packet.payload.size() != kJoinBytes) return std::nullopt;
  const std::uint32_t role = get(datagram, kUdpHeaderBytes, kJoinBytes);
  if (role != kJoinParticipant && role != kJoinObserver) return std::nullopt;
  packet.role = role == kJoinParticipant ? Role::kParticipant : Role::kObserver;
  return packet;
}

UdpBeginning read_udp_beginning(std::span<const std::uint8_t> stream) noexcept {
  for (std::size_t i = 0; i < std::min<std::size_t>(stream.size(), kRunAt); ++i)
    if (stream[i] != static_cast<std::uint8_t>(kMagic >> (24 - 8 * i))) return {true, 0};
  if (stream.size() < kUdpHeaderBytes) return {false, 0};
  const std::size_t length = get(stream, kLengthAt, 2);
  if (length > hil::kMaxWireBytes || get(stream, kKindAt, 2) > hil::kMessageKinds) return {true, 0};
  return {false, kUdpHeaderBytes + length};
}

bool UdpSequence::accept(const UdpHeader& header) noexcept {
  if (run_ != header.run) {
    run_ = header.run;
    next_ = header.sequence;
  }
  const std::uint32_t ahead = header.sequence - next_;
  if (ahead >= 0x80000000U) return false;
  lost_ += ahead;
  next_ = header.sequence + 1;
  return true;
}

}  // namespace unlatch::bridge
