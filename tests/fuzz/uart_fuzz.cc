// Frames in a stream of bytes: read in pieces of any length, decoded. Input: of each piece its length (1 byte) and its
// bytes; length 0: the line is silent.
#include <algorithm>
#include <memory>

#include "bridge/uart/frame_reader.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::size_t pushed = 0, framed = 0;
  bridge::FrameReader reader([&](const bridge::UdpPacket& packet) {
    framed += bridge::kUdpHeaderBytes + packet.payload.size();
    if (!packet.kind) return;
    hil::Message message;
    if (hil::decode(*packet.kind, packet.payload, message)) (void)hil::is_well_formed(message);
  });
  while (size > 0) {
    const std::size_t length = std::min<std::size_t>(data[0], size - 1);
    // A separate allocation, so that a sanitizer detects any read behind its end.
    const auto piece = std::make_unique<std::uint8_t[]>(length);
    std::copy_n(data + 1, length, piece.get());
    data += 1 + length;
    size -= 1 + length;
    const std::int64_t gaps = reader.get_gaps();
    if (length == 0) reader.give_up();
    reader.push({piece.get(), length});
    pushed += length;
    fuzz::require(framed <= pushed, "more frames than bytes");
    fuzz::require(reader.get_gaps() >= gaps, "fewer gaps than before");
  }
  return 0;
}
