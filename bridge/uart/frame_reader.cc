#include "bridge/uart/frame_reader.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace unlatch::bridge {

FrameReader::FrameReader(Accept accept) : accept_(std::move(accept)), bytes_(2 * kMaxUdpBytes) {}

void FrameReader::push(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    if (end_ == bytes_.size()) {  // less than a frame is left: the other half is free
      std::memmove(bytes_.data(), bytes_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    const std::size_t count = std::min(bytes.size(), bytes_.size() - end_);
    std::memcpy(bytes_.data() + end_, bytes.data(), count);
    end_ += count;
    bytes = bytes.subspan(count);
    read();
  }
}

void FrameReader::give_up() {
  while (begin_ < end_) {
    skip(1);
    read();
  }
}

// All frames that are complete. What is left afterwards is shorter than a frame.
void FrameReader::read() {
  while (begin_ < end_) {
    const std::span<const std::uint8_t> left(bytes_.data() + begin_, end_ - begin_);
    const UdpBeginning beginning = read_udp_beginning(left);
    if (beginning.is_none) {
      skip(1);
      continue;
    }
    if (beginning.bytes == 0 || beginning.bytes > left.size()) return;
    const auto packet = read_udp_packet(left.first(beginning.bytes));
    if (!packet) {
      skip(1);
      continue;
    }
    in_gap_ = false;
    begin_ += beginning.bytes;
    accept_(*packet);
  }
}

void FrameReader::skip(std::size_t count) {
  gaps_ += in_gap_ ? 0 : 1;
  in_gap_ = true;
  begin_ += count;
}

}  // namespace unlatch::bridge
