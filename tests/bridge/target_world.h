// A board at one end of a serial line and flight software at the other, in one thread: serial.h and port.h of
// kernel/targets as a test sees them. Time goes on with every look at the clock.
#pragma once

#include <deque>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "bridge/participant/participant.h"
#include "bridge/schema/unlatch_frame.h"

namespace unlatch::test {

struct TargetWorld {
  std::deque<std::uint8_t> to_board, from_board;
  std::uint64_t now_us = 0;
  std::string printed;
  // What becomes of a frame or of bytes on the line, in either direction.
  std::function<void(std::vector<std::uint8_t>&)> disturb = [](std::vector<std::uint8_t>&) {};
  // The other end, with all that has come; called whenever the board waits.
  std::function<void()> other_end = [] {};
  void send_to_board(const std::uint8_t* bytes, std::size_t count) {
    std::vector<std::uint8_t> sent(bytes, bytes + count);
    disturb(sent);
    to_board.insert(to_board.end(), sent.begin(), sent.end());
  }
};
// The one of the test that runs; the board's functions are C functions and know no other.
extern TargetWorld* target_world;

// Flight software of bridge/participant at the other end.
class LineParticipant {
 public:
  explicit LineParticipant(TargetWorld& world, std::uint32_t number, std::function<void(unlatch_participant&)> update);
  void run();
  [[nodiscard]] const unlatch_participant& get() const { return participant_; }
  int refused = 0, ended = 0;
  std::int32_t last_reason = -1;
  bool mute = false;  // hears, and says nothing
  // The messages of the simulator, before the participant has them.
  std::function<void(const unlatch_frame&)> look = [](const unlatch_frame&) {};

 private:
  static void send(unlatch_participant* p, const std::uint8_t* frame, std::size_t length);

  TargetWorld& world_;
  std::function<void(unlatch_participant&)> update_;
  unlatch_participant participant_{};
  unlatch_frame_stream stream_{};
  unlatch_frame_order order_{};
  std::uint64_t joined_us_ = 0, heard_us_ = 0;
};

}  // namespace unlatch::test
