#include "bridge/target/frame_line.h"

#include "kernel/targets/serial.h"

namespace unlatch::target {

FrameLine::FrameLine() { open_serial(); }

void FrameLine::send(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes)
    while (!write_serial(byte)) take();
}

// What finds no place is lost, as on the line.
void FrameLine::take() {
  std::uint8_t byte;
  while (read_serial(byte)) {
    heard_us_ = read_clock_us();
    if (end_ - begin_ < kKept) kept_[end_++ % kKept] = byte;
  }
}

bool FrameLine::pop(std::uint8_t& byte) {
  if (begin_ == end_) return false;
  byte = kept_[begin_++ % kKept];
  return true;
}

bool FrameLine::find(unlatch_frame& frame) {
  while (unlatch_frame_next(&stream_, &frame) != 0)
    if (unlatch_frame_is_new(&order_, &frame) != 0) return true;
  return false;
}

bool FrameLine::receive(unlatch_frame& frame) {
  if (find(frame)) return true;
  take();
  std::uint8_t byte;
  while (pop(byte)) {
    unlatch_frame_push(&stream_, byte);
    if (find(frame)) return true;
  }
  if (read_clock_us() - heard_us_ < kSilence_us) return false;
  while (unlatch_frame_give_up(&stream_) != 0)
    if (find(frame)) return true;
  return false;
}

}  // namespace unlatch::target
