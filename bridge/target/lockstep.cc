// The way of a session; what comes and what goes: lockstep_messages.cc.
#include "bridge/target/lockstep.h"

#include <cstring>

#include "kernel/targets/serial.h"
#include "kernel/targets/text_line.h"

namespace unlatch::target {
namespace {

constexpr std::uint64_t kResend_us = 20'000;     // of silence, after which the State is sent again
constexpr std::uint64_t kPatience_us = 100'000;  // then the other end may have started anew, and gets all of it again
constexpr int kFinalStates = 3;
constexpr std::uint64_t kFinalInterval_us = 5'000;
constexpr std::int64_t kHashEvery = 100;  // ticks

}  // namespace

const char* Lockstep::open() {
  const unlatch_wire_hello& hello = parts_.image.get_hello();
  const std::span<const double> initial = parts_.plan.get_initial_commands();
  if (static_cast<std::uint64_t>(hello.model_hash) != parts_.plan.get_hash())
    return "the plan and the session image are not of one scenario: compile both with one call of unlatch compile";
  if (hello.participant_count != 1) return "the session image has not one required participant";
  if (!commands_.open(parts_.image) || initial.size() != static_cast<std::size_t>(hello.channel_count))
    return "the scenario has more channels than PendingCommands::kMostChannels";
  std::memcpy(channels_, initial.data(), initial.size_bytes());
  return nullptr;
}

bool Lockstep::run() {
  init_state(parts_.plan, parts_.state);
  const std::size_t count = parts_.plan.get_initial_commands().size();
  if (update_outputs(parts_.plan, Inputs{{channels_, count}}, parts_.state, parts_.workspace) != StepStatus::kOk)
    return false;
  introduce();
  publish_state(UNLATCH_RUN_STATUS_CONFIGURED);
  wait_for_answer(UNLATCH_RUN_STATUS_CONFIGURED);
  repeat_state(UNLATCH_RUN_STATUS_ARMED);
  resent_ = 0;
  status_ = UNLATCH_RUN_STATUS_RUNNING;
  while (get_tick() < parts_.image.get_hello().last_tick) {
    wait_for_answer(get_tick() == 0 ? UNLATCH_RUN_STATUS_ARMED : UNLATCH_RUN_STATUS_RUNNING);
    if (const StepStatus status = make_step(); status != StepStatus::kOk) {
      TextLine() << "tick " << static_cast<std::uint64_t>(get_tick()) << ": " << get_status_text(status) << "\n";
      conclude(UNLATCH_RUN_STATUS_FAULTED);
      return false;
    }
    print_hash();
    const bool is_last = get_tick() == parts_.image.get_hello().last_tick;
    publish_state(is_last ? UNLATCH_RUN_STATUS_DONE : UNLATCH_RUN_STATUS_RUNNING);
  }
  conclude(UNLATCH_RUN_STATUS_DONE);
  return true;
}

void Lockstep::introduce() {
  status_ = UNLATCH_RUN_STATUS_DISCOVER;
  unlatch_frame frame;
  while (!is_present_) {
    if (parts_.line.receive(frame))
      hear(frame);
    else
      announce();
  }
  status_ = UNLATCH_RUN_STATUS_CONFIGURED;
}

void Lockstep::wait_for_answer(int status) {
  std::uint64_t sent_us = read_clock_us();
  const std::uint64_t began_us = sent_us;
  unlatch_frame frame;
  while (!is_answered()) {
    if (parts_.line.receive(frame)) {
      hear(frame);
      continue;
    }
    const std::uint64_t now_us = read_clock_us(), quiet_since_us = news_us_ > sent_us ? news_us_ : sent_us;
    if (!is_present_ || now_us - began_us >= kPatience_us) announce();
    if (now_us - quiet_since_us < kResend_us) continue;
    const auto timeout_us = static_cast<std::uint64_t>(parts_.image.get_hello().timeout_ns / 1000);
    const bool is_paused = status == UNLATCH_RUN_STATUS_RUNNING && now_us - began_us > timeout_us;
    repeat_state(is_paused ? int{UNLATCH_RUN_STATUS_PAUSED} : status);
    sent_us = read_clock_us();
  }
}

StepStatus Lockstep::make_step() {
  while (const unlatch_wire_command* command = commands_.take_due(get_tick()))
    channels_[command->channel] = command->value;
  verdicts_left_ = kVerdictsPerTick;
  const std::size_t count = parts_.plan.get_initial_commands().size();
  return step(parts_.plan, Inputs{{channels_, count}}, parts_.state, parts_.workspace).status;
}

void Lockstep::conclude(int status) {
  status_ = status;
  unlatch_frame frame;
  for (int i = 0; i < kFinalStates; ++i) {
    repeat_state(status);
    const std::uint64_t end_us = read_clock_us() + kFinalInterval_us;
    while (read_clock_us() < end_us) (void)parts_.line.receive(frame);
  }
  TextLine() << "# resent " << resent_ - kFinalStates << ", refused " << refused_ << ", not understood "
             << parts_.line.get_gaps() << "\n";
}

void Lockstep::print_hash() const {
  const unlatch_wire_hello& hello = parts_.image.get_hello();
  if (get_tick() % kHashEvery != 0 && get_tick() != hello.last_tick) return;
  TextLine line;
  line << reinterpret_cast<const char*>(hello.scenario) << " " << static_cast<std::uint64_t>(get_tick()) << " ";
  line.add_hash(calc_hash(parts_.state)) << "\n";
}

}  // namespace unlatch::target
