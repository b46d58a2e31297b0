#include "tests/bridge/target_world.h"

#include "kernel/targets/port.h"
#include "kernel/targets/serial.h"

namespace unlatch::test {

TargetWorld* target_world = nullptr;

namespace {
constexpr std::uint64_t kJoinEvery_us = 100'000, kSilence_us = 500'000;
}

LineParticipant::LineParticipant(TargetWorld& world, std::uint32_t number,
                                 std::function<void(unlatch_participant&)> update)
    : world_(world), update_(std::move(update)) {
  unlatch_participant_begin(&participant_, "fsw", number, send, this);
}

void LineParticipant::send(unlatch_participant* p, const std::uint8_t* frame, std::size_t length) {
  auto& self = *static_cast<LineParticipant*>(p->link);
  if (!self.mute) self.world_.send_to_board(frame, length);
}

void LineParticipant::run() {
  if (joined_us_ == 0 || world_.now_us - joined_us_ > kJoinEvery_us) {
    joined_us_ = world_.now_us;
    unlatch_participant_join(&participant_);
  }
  std::vector<std::uint8_t> come(world_.from_board.begin(), world_.from_board.end());
  world_.from_board.clear();
  world_.disturb(come);
  if (!come.empty()) heard_us_ = world_.now_us;
  const auto read_all = [this] {
    unlatch_frame frame;
    while (unlatch_frame_next(&stream_, &frame) != 0) {
      if (unlatch_frame_is_new(&order_, &frame) == 0) continue;
      look(frame);
      const std::uint8_t* const begin = frame.payload - UNLATCH_FRAME_HEADER_BYTES;
      switch (unlatch_participant_hear(&participant_, begin, frame.length + UNLATCH_FRAME_HEADER_BYTES)) {
        case UNLATCH_PARTICIPANT_STATE:
          update_(participant_);
          unlatch_participant_answer(&participant_);
          break;
        case UNLATCH_PARTICIPANT_REFUSED:
          ++refused;
          last_reason = participant_.verdict.reason;
          break;
        case UNLATCH_PARTICIPANT_END:
          ++ended;
          break;
        default:
          break;
      }
    }
  };
  for (const std::uint8_t byte : come) {
    unlatch_frame_push(&stream_, byte);
    read_all();
  }
  if (world_.now_us - heard_us_ > kSilence_us)
    while (unlatch_frame_give_up(&stream_) != 0) read_all();
}

}  // namespace unlatch::test

namespace unlatch::target {

void write(const char* text) { test::target_world->printed += text; }
void finish(int) { std::abort(); }
void open_serial() {}
bool read_serial(std::uint8_t& byte) {
  test::TargetWorld& world = *test::target_world;
  if (world.to_board.empty()) world.other_end();
  if (world.to_board.empty()) return false;
  byte = world.to_board.front();
  world.to_board.pop_front();
  return true;
}
bool write_serial(std::uint8_t byte) {
  test::target_world->from_board.push_back(byte);
  return true;
}
std::uint64_t read_clock_us() { return test::target_world->now_us += 50; }
std::uint32_t draw_start_number() { return 7; }

}  // namespace unlatch::target
