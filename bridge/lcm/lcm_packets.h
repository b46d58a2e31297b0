// LCM's datagrams, inspected before anything is read from them: liblcm 1.3.1 copies a fragment outside its buffer when
// the offset is close to 2^32, so no datagram of the network reaches it.
//
// A datagram, numbers big-endian (LCM's "UDP multicast protocol"):
//   short     u32 0x4c433032 "LC02", u32 sequence; channel, NUL; data
//   fragment  u32 0x4c433033 "LC03", u32 sequence, u32 size of the data, u32 offset, u16 fragment, u16 fragments;
//             fragment 0: channel, NUL; data from the offset on
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "hil/session/messages/messages.h"

namespace unlatch::bridge {

inline constexpr std::uint32_t kLcmShort = 0x4c433032, kLcmFragment = 0x4c433033;
inline constexpr std::size_t kLcmShortHeader = 8, kLcmFragmentHeader = 20;
inline constexpr std::size_t kLcmChannelLength = 63;  // at most, without NUL

// Puts fragments together. Fixed memory: kSenders messages at a time, one of each sender, none longer than ours.
class LcmPackets {
 public:
  static constexpr std::size_t kSenders = 16;
  static constexpr std::size_t kMaxFragments =
      64;  // of one message; ours fit into three of the smallest that are in use

  enum class Result {
    kMessage,    // one is complete
    kPart,       // a fragment of one
    kForeign,    // LCM's, on a channel that is none of ours
    kMalformed,  // no datagram of LCM's, or a fragment that contradicts itself or the others of its message
  };
  struct Packet {
    hil::MessageKind kind{};
    std::span<const std::uint8_t> data;  // valid until the next call
  };

  // `sender`: its address and port as a number. Never reads outside `datagram`.
  Result accept(std::uint64_t sender, std::span<const std::uint8_t> datagram, Packet& packet);

 private:
  struct Piece {
    std::uint32_t offset = 0, length = 0;
    bool has_come = false;
  };
  // A message of which fragments are missing.
  struct Partial {
    bool is_used = false;
    std::uint64_t sender = 0;
    std::uint32_t sequence = 0, size = 0;
    std::uint16_t fragments = 0, come = 0;
    std::optional<hil::MessageKind> kind;  // once fragment 0 has come; none: of no interest to us
    std::uint64_t touched = 0;
    std::array<Piece, kMaxFragments> pieces{};
    std::array<std::uint8_t, hil::kMaxWireBytes> data{};
  };
  struct Fragment {
    std::uint32_t sequence, size, offset;
    std::uint16_t number, count;
    std::span<const std::uint8_t> data;
    std::optional<hil::MessageKind> kind;
  };

  Result accept_fragment(std::uint64_t sender, std::span<const std::uint8_t> datagram, Packet& packet);
  Partial& find_or_begin(std::uint64_t sender, const Fragment& fragment);
  [[nodiscard]] static bool has_no_gaps(const Partial& partial);

  std::vector<Partial> partials_ = std::vector<Partial>(kSenders);
  std::uint64_t clock_ = 0;  // counts fragments
};

}  // namespace unlatch::bridge
