// Datagrams of the UDP transport: read, put in order, stored, decoded. Input: of each datagram its length (2 bytes,
// little-endian) and its bytes; in every second one the checksum is corrected first.
#include <algorithm>
#include <cstring>
#include <memory>

#include "bridge/core/message_ring.h"
#include "bridge/udp/udp_packet.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

// Corrects the checksum; otherwise hardly any input would pass it.
void mend(std::span<std::uint8_t> datagram) {
  if (datagram.size() < bridge::kUdpHeaderBytes) return;
  constexpr std::size_t kChecksumAt = 16;
  std::memset(datagram.data() + kChecksumAt, 0, 4);
  const std::uint32_t checksum = bridge::calc_crc32(datagram);
  for (std::size_t i = 0; i < 4; ++i) datagram[kChecksumAt + i] = static_cast<std::uint8_t>(checksum >> (24 - 8 * i));
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 2;
  static bridge::MessageRing ring(3 * hil::kMaxWireBytes);
  bridge::UdpSequence sequence;
  for (bool as_it_is = false; size >= kHead; as_it_is = !as_it_is) {
    const std::size_t length = std::min(static_cast<std::size_t>(data[0] | data[1] << 8), size - kHead);
    // A separate allocation, so that a sanitizer detects any read behind its end.
    const auto datagram = std::make_unique<std::uint8_t[]>(length);
    std::copy_n(data + kHead, length, datagram.get());
    data += kHead + length;
    size -= kHead + length;
    if (!as_it_is) mend({datagram.get(), length});

    const auto packet = bridge::read_udp_packet({datagram.get(), length});
    if (!packet) continue;
    const std::int64_t lost = sequence.get_lost();
    if (!sequence.accept(packet->header)) continue;
    fuzz::require(sequence.get_lost() >= lost, "fewer datagrams lost than before");
    if (!packet->kind) continue;
    fuzz::require(hil::get_size(*packet->kind) > 0, "a message of no kind");
    hil::Message direct, kept;
    const bool is_readable = hil::decode(*packet->kind, packet->payload, direct);
    ring.push(*packet->kind, packet->payload);
    bool is_kept_readable = false;
    if (!ring.pop(kept, is_kept_readable, std::chrono::nanoseconds::zero())) continue;  // longer than any message
    fuzz::require(is_readable == is_kept_readable, "kept bytes read otherwise");
    if (is_readable) (void)hil::is_well_formed(kept);
  }
  return 0;
}
