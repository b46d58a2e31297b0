// Datagrams of several senders, in the form of the network: inspected, joined, stored, decoded. Input: of each datagram
// its sender (1 byte), its length (2 bytes, little-endian) and its bytes.
#include <algorithm>
#include <cstring>
#include <memory>

#include "bridge/core/message_ring.h"
#include "bridge/lcm/lcm_packets.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 3, kRingBytes = 3 * hil::kMaxWireBytes;
  static bridge::LcmPackets packets;  // unfinished fragments of earlier inputs belong to the test
  static bridge::MessageRing ring(kRingBytes), crowded(kRingBytes);
  while (size >= kHead) {
    const std::uint64_t sender = data[0];
    const std::size_t length = std::min(static_cast<std::size_t>(data[1] | data[2] << 8), size - kHead);
    // A separate allocation, so that a sanitizer detects any read behind its end.
    const auto datagram = std::make_unique<std::uint8_t[]>(length);
    std::copy_n(data + kHead, length, datagram.get());
    data += kHead + length;
    size -= kHead + length;

    bridge::LcmPackets::Packet packet;
    using Result = bridge::LcmPackets::Result;
    if (packets.accept(sender, {datagram.get(), length}, packet) != Result::kMessage) continue;
    fuzz::require(hil::get_size(packet.kind) > 0, "a message of no kind");
    hil::Message direct, kept;
    const bool is_readable = hil::decode(packet.kind, packet.data, direct);
    ring.push(packet.kind, packet.data);
    bool is_kept_readable = false;
    fuzz::require(ring.pop(kept, is_kept_readable, std::chrono::nanoseconds::zero()), "a message that was not kept");
    fuzz::require(is_readable == is_kept_readable, "kept bytes read otherwise");
    if (!is_readable) continue;
    fuzz::require(direct.kind == kept.kind, "another kind");
    fuzz::require(std::memcmp(&direct.hello, &kept.hello, hil::get_size(direct.kind)) == 0, "other bytes");
    (void)hil::is_well_formed(kept);
    crowded.push(packet.kind, packet.data);  // always full: the oldest are dropped
  }
  return 0;
}
