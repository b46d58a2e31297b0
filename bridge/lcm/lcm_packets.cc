#include "bridge/lcm/lcm_packets.h"

#include <algorithm>
#include <cstring>

namespace unlatch::bridge {
namespace {

std::uint32_t read_number(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t length) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < length; ++i) number = number << 8U | bytes[at + i];
  return number;
}

// The channel at the beginning of `bytes`, which are then behind it; none without a NUL in its place.
std::optional<std::string_view> take_channel(std::span<const std::uint8_t>& bytes) {
  const auto begin = bytes.begin(),
             limit = begin + static_cast<std::ptrdiff_t>(std::min(bytes.size(), kLcmChannelLength + 1));
  const auto end = std::find(begin, limit, std::uint8_t{0});
  if (end == limit) return std::nullopt;
  const auto length = static_cast<std::size_t>(end - begin);
  const std::string_view channel(reinterpret_cast<const char*>(bytes.data()), length);
  bytes = bytes.subspan(length + 1);
  return channel;
}

}  // namespace

LcmPackets::Result LcmPackets::accept(std::uint64_t sender, std::span<const std::uint8_t> datagram, Packet& packet) {
  if (datagram.size() < kLcmShortHeader) return Result::kMalformed;
  const std::uint32_t magic = read_number(datagram, 0, 4);
  if (magic == kLcmFragment) return accept_fragment(sender, datagram, packet);
  if (magic != kLcmShort) return Result::kMalformed;
  std::span<const std::uint8_t> rest = datagram.subspan(kLcmShortHeader);
  const auto channel = take_channel(rest);
  if (!channel) return Result::kMalformed;
  if (!hil::find_kind(*channel, packet.kind)) return Result::kForeign;
  packet.data = rest;
  return Result::kMessage;
}

LcmPackets::Result LcmPackets::accept_fragment(std::uint64_t sender, std::span<const std::uint8_t> datagram,
                                               Packet& packet) {
  if (datagram.size() < kLcmFragmentHeader) return Result::kMalformed;
  Fragment fragment{read_number(datagram, 4, 4),
                    read_number(datagram, 8, 4),
                    read_number(datagram, 12, 4),
                    static_cast<std::uint16_t>(read_number(datagram, 16, 2)),
                    static_cast<std::uint16_t>(read_number(datagram, 18, 2)),
                    datagram.subspan(kLcmFragmentHeader),
                    {}};
  if (fragment.number >= fragment.count) return Result::kMalformed;
  if (fragment.number == 0) {
    const auto channel = take_channel(fragment.data);
    if (!channel) return Result::kMalformed;
    hil::MessageKind kind{};
    if (hil::find_kind(*channel, kind)) fragment.kind = kind;
  }
  const std::size_t length = fragment.data.size();
  if (fragment.offset > fragment.size || length > fragment.size - fragment.offset) return Result::kMalformed;
  // Well-formed, but too long or in too many pieces for one of ours: somebody else's.
  if (fragment.size > hil::kMaxWireBytes || fragment.count > kMaxFragments) return Result::kForeign;

  Partial& partial = find_or_begin(sender, fragment);
  if (fragment.size != partial.size || fragment.count != partial.fragments) {
    partial.is_used = false;
    return Result::kMalformed;
  }
  Piece& piece = partial.pieces[fragment.number];
  if (piece.has_come) return Result::kPart;  // once more
  piece = {fragment.offset, static_cast<std::uint32_t>(length), true};
  std::copy(fragment.data.begin(), fragment.data.end(),
            partial.data.begin() + static_cast<std::ptrdiff_t>(fragment.offset));
  if (fragment.number == 0) partial.kind = fragment.kind;
  if (++partial.come < partial.fragments) return Result::kPart;

  partial.is_used = false;
  if (!has_no_gaps(partial)) return Result::kMalformed;
  if (!partial.kind) return Result::kForeign;
  packet.kind = *partial.kind;
  packet.data = std::span(partial.data).first(partial.size);
  return Result::kMessage;
}

// A sender sends one message after the other: a new one takes the place of what is left of the last, and among more
// senders than places, of the one that has rested longest.
LcmPackets::Partial& LcmPackets::find_or_begin(std::uint64_t sender, const Fragment& fragment) {
  Partial* place = nullptr;
  for (Partial& partial : partials_) {
    if (!partial.is_used || partial.sender != sender) continue;
    if (partial.sequence == fragment.sequence) {
      partial.touched = ++clock_;
      return partial;
    }
    place = &partial;
  }
  if (place == nullptr) {
    place = &*std::min_element(partials_.begin(), partials_.end(), [](const Partial& a, const Partial& b) {
      return a.is_used != b.is_used ? !a.is_used : a.touched < b.touched;
    });
  }
  place->is_used = true;
  place->sender = sender;
  place->sequence = fragment.sequence;
  place->size = fragment.size;
  place->fragments = fragment.count;
  place->come = 0;
  place->kind.reset();
  place->touched = ++clock_;
  std::fill_n(place->pieces.begin(), fragment.count, Piece{});
  return *place;
}

// Each piece begins where the one before it ends, and the last ends with the message.
bool LcmPackets::has_no_gaps(const Partial& partial) {
  std::uint32_t end = 0;
  for (std::size_t i = 0; i < partial.fragments; ++i) {
    if (partial.pieces[i].offset != end) return false;
    end += partial.pieces[i].length;
  }
  return end == partial.size;
}

}  // namespace unlatch::bridge
