// Frames over the board's serial port (bridge/UART.md), in both directions at once: while bytes leave, those that come
// are kept. No heap.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bridge/schema/unlatch_frame.h"

namespace unlatch::target {

class FrameLine {
 public:
  // Turns the port on.
  FrameLine();

  // Waits until the line has taken all of it.
  void send(std::span<const std::uint8_t> bytes);
  // The next whole frame, in order; it lies here until the next call. False: none has come.
  bool receive(unlatch_frame& frame);

  // Runs of bytes that belong to no frame; frames that came late or twice.
  [[nodiscard]] std::uint64_t get_gaps() const { return static_cast<std::uint64_t>(stream_.gaps); }

 private:
  static constexpr std::uint64_t kSilence_us = 500'000;  // after which a frame that has begun is not continued
  static constexpr std::size_t kKept = 4096;             // bytes that have come and are not read yet; a power of two

  void take();
  bool pop(std::uint8_t& byte);
  bool find(unlatch_frame& frame);

  unlatch_frame_stream stream_{};
  unlatch_frame_order order_{};
  std::uint8_t kept_[kKept]{};
  std::size_t begin_ = 0, end_ = 0;  // of what is kept, counted on
  std::uint64_t heard_us_ = 0;
};

}  // namespace unlatch::target
