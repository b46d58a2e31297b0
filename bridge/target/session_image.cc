#include "bridge/target/session_image.h"

namespace unlatch::target {
namespace {

constexpr std::size_t kHelloBytes = std::size_t{UNLATCH_FRAME_HEADER_BYTES} + UNLATCH_WIRE_HELLO_BYTES;
constexpr std::size_t kItemBytes = std::size_t{UNLATCH_FRAME_HEADER_BYTES} + UNLATCH_WIRE_CATALOG_BYTES;
constexpr const char* kBroken = "the session image is not whole: compile it again, and load all of it";

}  // namespace

const char* SessionImage::open(std::span<const std::uint8_t> bytes) {
  unlatch_frame frame;
  if (bytes.size() < kHelloBytes || unlatch_frame_read(&frame, bytes.data(), kHelloBytes) == 0) return kBroken;
  if (unlatch_wire_decode_hello(&hello_, frame.payload, frame.length) == 0 ||
      hello_.schema_hash != UNLATCH_WIRE_SCHEMA_HASH || hello_.protocol != UNLATCH_WIRE_PROTOCOL)
    return "the session image is of another version of the messages: compile it with the unlatch of this source";
  items_ = bytes.subspan(kHelloBytes);
  const std::int32_t counts[] = {hello_.body_count,   hello_.joint_count,  hello_.channel_count,
                                 hello_.sensor_count, hello_.signal_count, hello_.participant_count};
  count_ = 0;
  for (const std::int32_t count : counts) count_ += static_cast<std::size_t>(count);
  if (items_.size() != count_ * kItemBytes) return kBroken;
  for (std::size_t i = 0; i < count_; ++i) {
    unlatch_wire_catalog item;
    if (unlatch_frame_read(&frame, items_.data() + i * kItemBytes, kItemBytes) == 0 ||
        unlatch_wire_decode_catalog(&item, frame.payload, frame.length) == 0)
      return kBroken;
  }
  return nullptr;
}

unlatch_wire_catalog SessionImage::get_item(std::size_t i) const {
  unlatch_wire_catalog item{};
  (void)unlatch_wire_decode_catalog(&item, items_.data() + i * kItemBytes + UNLATCH_FRAME_HEADER_BYTES,
                                    UNLATCH_WIRE_CATALOG_BYTES);
  return item;
}

}  // namespace unlatch::target
