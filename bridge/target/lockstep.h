// A session in lockstep with one participant at the other end of the line, as hil/PROTOCOL.md describes it; README.md
// says which parts of it. It waits for the participant as long as it takes. No heap.
#pragma once

#include <cstdint>
#include <span>

#include "bridge/target/frame_line.h"
#include "bridge/target/pending_commands.h"
#include "bridge/target/session_image.h"
#include "unlatch/plan.h"
#include "unlatch/step.h"

namespace unlatch::target {

class Lockstep {
 public:
  struct Parts {
    const Plan& plan;
    State& state;
    Workspace& workspace;
    const SessionImage& image;
    FrameLine& line;
  };
  explicit Lockstep(const Parts& parts) : parts_(parts) {}

  // Null, or what is wrong: the plan, the image and the memory of this program do not fit together.
  const char* open();
  // The whole session, from tick 0 to the last; prints NAME TICK HASH every 100 ticks. False: the step has failed.
  bool run();

 private:
  static constexpr int kVerdictsPerTick = 16;

  // The way of a session.
  void introduce();
  void wait_for_answer(int status);
  [[nodiscard]] StepStatus make_step();
  void conclude(int status);

  // What comes.
  void hear(const unlatch_frame& frame);
  void hear(const unlatch_wire_hello_ack& answer);
  void hear(const unlatch_wire_command& command);
  void hear(const unlatch_wire_step_ack& ack);
  void admit(const unlatch_wire_hello_ack& answer);
  [[nodiscard]] bool is_answered() const;

  // What goes.
  void announce();
  void publish_state(int status);
  void repeat_state(int status);
  void ask_for_missing();
  void refuse(std::int32_t reason, std::int64_t sequence, std::int32_t participant, std::int32_t channel);
  void send_verdict(unlatch_wire_verdict verdict);
  void send(int kind, std::size_t bytes);
  [[nodiscard]] std::span<std::uint8_t> get_message();
  void fill_state(std::int32_t part, int status);
  [[nodiscard]] std::int32_t count_parts() const;
  void print_hash() const;

  [[nodiscard]] std::int64_t get_tick() const { return parts_.state.header->tick; }

  const Parts parts_;
  PendingCommands commands_;
  double channels_[PendingCommands::kMostChannels]{};
  std::int64_t session_ = 0;  // 0: nobody has joined yet
  std::uint32_t run_ = 0, sent_ = 0;
  int status_ = UNLATCH_RUN_STATUS_DISCOVER;

  // The participant.
  bool is_present_ = false;
  std::uint32_t its_run_ = 0;
  std::int32_t its_number_ = 0;
  unlatch_wire_step_ack ack_{};
  std::uint64_t heard_us_ = 0;  // any frame
  std::uint64_t news_us_ = 0;   // an answer

  std::uint64_t announced_us_ = 0, hello_us_ = 0;
  std::size_t next_item_ = 0;
  std::int64_t hellos_ = 0, items_ = 0, states_ = 0, verdicts_ = 0;
  int verdicts_left_ = kVerdictsPerTick;
  std::uint64_t resent_ = 0, refused_ = 0;
  unlatch_wire_state message_{};
  std::uint8_t frame_[UNLATCH_FRAME_LONGEST]{};
};

}  // namespace unlatch::target
