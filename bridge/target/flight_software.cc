// Flight software on a board without operating system, with the simulator at the other end of a serial line: the
// separation sequence of the boosters, as participant 'fsw'.
#include "bridge/target/frame_line.h"
#include "bridge/target/separation.h"
#include "kernel/targets/port.h"
#include "kernel/targets/serial.h"
#include "kernel/targets/text_line.h"

namespace unlatch::target {
namespace {

constexpr std::uint64_t kJoinEvery_us = 100'000;

void send(unlatch_participant* p, const std::uint8_t* frame, std::size_t length) {
  static_cast<FrameLine*>(p->link)->send({frame, length});
}

// True: the session is over.
bool handle(unlatch_participant_event event, unlatch_participant& p, unlatch_separation& sequence) {
  switch (event) {
    case UNLATCH_PARTICIPANT_STATE:
      if (p.state.tick == 0) unlatch_separation_begin(&sequence);
      unlatch_separation_update(&sequence, &p);
      unlatch_participant_answer(&p);
      return false;
    case UNLATCH_PARTICIPANT_REFUSED:
      TextLine() << "flight software: refused, reason " << static_cast<std::uint64_t>(p.verdict.reason) << "\n";
      return false;
    case UNLATCH_PARTICIPANT_END:
      TextLine() << "flight software: the session has ended at tick " << static_cast<std::uint64_t>(p.state.tick)
                 << "\n";
      return true;
    default:
      return false;
  }
}

void take_part() {
  static FrameLine line;
  static unlatch_participant p;
  static unlatch_separation sequence;
  unlatch_separation_begin(&sequence);
  unlatch_participant_begin(&p, "fsw", draw_start_number(), send, &line);
  std::uint64_t joined_us = 0;
  unlatch_frame frame;
  for (;;) {
    const std::uint64_t now_us = read_clock_us();
    if (joined_us == 0 || now_us - joined_us >= kJoinEvery_us) {
      unlatch_participant_join(&p);
      joined_us = now_us;
    }
    if (!line.receive(frame)) continue;
    const std::uint8_t* const begin = frame.payload - UNLATCH_FRAME_HEADER_BYTES;
    if (handle(unlatch_participant_hear(&p, begin, frame.length + UNLATCH_FRAME_HEADER_BYTES), p, sequence)) return;
  }
}

}  // namespace
}  // namespace unlatch::target

int main() {
  unlatch::target::take_part();
  unlatch::target::finish(0);
}
