// Frames in a stream of bytes: the datagrams of the UDP transport (bridge/udp/udp_packet.h), one behind the other. What
// is no frame is skipped, byte by byte, so that no frame is lost behind it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bridge/udp/udp_packet.h"

namespace unlatch::bridge {

class FrameReader {
 public:
  // Called for each frame, in order; the packet lies in the reader's memory until it returns.
  using Accept = std::function<void(const UdpPacket&)>;

  explicit FrameReader(Accept accept);

  // Any number of bytes, from any place on.
  void push(std::span<const std::uint8_t> bytes);
  // The line is silent: a frame that has begun is not continued. What of it may be another frame is read.
  void give_up();

  // Runs of bytes that belong to no frame.
  [[nodiscard]] std::int64_t get_gaps() const noexcept { return gaps_; }

 private:
  void read();
  void skip(std::size_t count);

  const Accept accept_;
  std::vector<std::uint8_t> bytes_;
  std::size_t begin_ = 0, end_ = 0;  // of what has not been read
  bool in_gap_ = false;
  std::int64_t gaps_ = 0;
};

}  // namespace unlatch::bridge
