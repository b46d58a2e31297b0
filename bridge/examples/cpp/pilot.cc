// Flight software in C++ over LCM, with the classes that lcm-gen makes: takes part in a lockstep session of probe.yaml
// as 'pilot', opens the throttle at tick 100 and shuts it at tick 300.
#include <cstdio>
#include <cstring>
#include <lcm/lcm-cpp.hpp>

#include "unlatch/Catalog.hpp"
#include "unlatch/Command.hpp"
#include "unlatch/Hello.hpp"
#include "unlatch/HelloAck.hpp"
#include "unlatch/State.hpp"
#include "unlatch/StepAck.hpp"

namespace {

constexpr int kParticipant = 1002;
constexpr std::int64_t kOpenAt = 100, kShutAt = 300;
constexpr int kPatience_ms = 30'000;
constexpr std::int64_t kGone_us = 2'000'000;  // a simulator that has been silent for so long is gone

class Pilot {
 public:
  explicit Pilot(lcm::LCM& lcm) : lcm_(lcm) {
    lcm.subscribe("UNLATCH_HELLO", &Pilot::hear_hello, this)->setQueueCapacity(1024);
    lcm.subscribe("UNLATCH_CATALOG", &Pilot::hear_catalog, this)->setQueueCapacity(1024);
    lcm.subscribe("UNLATCH_STATE", &Pilot::hear_state, this)->setQueueCapacity(1024);
  }

  bool has_ended() const { return end_.status >= unlatch::State::RunStatus_kDone; }
  const unlatch::State& get_end() const { return end_; }

 private:
  void hear_hello(const lcm::ReceiveBuffer* buffer, const std::string&, const unlatch::Hello* hello) {
    if (hello->status >= unlatch::Hello::RunStatus_kDone) return;  // kept from a session that is over
    if (hello->session != session_) {
      if (session_ != 0 && buffer->recv_utime - heard_us_ < kGone_us) return warn_of_other(*hello);
      session_ = hello->session;
      throttle_ = -1;
      answered_tick_ = -1;
      last_command_ = 0;
      introduction_ = unlatch::HelloAck{};
      introduction_.session = hello->session;
      introduction_.schema_hash = unlatch::HelloAck::kSchemaHash;
      introduction_.protocol = unlatch::HelloAck::kProtocolVersion;
      introduction_.model_hash = hello->model_hash;
      introduction_.dt_ns = hello->dt_ns;
      introduction_.participant = kParticipant;
      introduction_.status = unlatch::HelloAck::AckStatus_kReady;
      std::memcpy(introduction_.name, "pilot", sizeof "pilot");
    }
    heard_us_ = buffer->recv_utime;
    introduce();
  }

  // Stays with its session, and says so once.
  void warn_of_other(const unlatch::Hello& hello) {
    if (warned_) return;
    warned_ = true;
    std::fprintf(stderr, "pilot: another simulator is heard, session %lld; stays with session %lld\n",
                 static_cast<long long>(hello.session), static_cast<long long>(session_));
  }

  void hear_catalog(const lcm::ReceiveBuffer*, const std::string&, const unlatch::Catalog* item) {
    if (item->session != session_ || item->kind != unlatch::Catalog::CatalogKind_kChannel) return;
    if (std::strcmp(reinterpret_cast<const char*>(item->name), "throttle") != 0) return;
    const bool news = throttle_ < 0;
    throttle_ = item->index;
    if (news) introduce();
  }

  void introduce() {
    if (session_ == 0 || throttle_ < 0) return;
    lcm_.publish("UNLATCH_HELLO_ACK", &introduction_);
    ++introduction_.sequence;
  }

  // A State that is resent is answered again, with the same numbers.
  void hear_state(const lcm::ReceiveBuffer* buffer, const std::string&, const unlatch::State* state) {
    if (state->session != session_ || throttle_ < 0 || state->part != 0 || has_ended()) return;
    heard_us_ = buffer->recv_utime;
    if (state->status >= unlatch::State::RunStatus_kDone) {
      end_ = *state;
      return;
    }
    if (state->tick < answered_tick_) return;
    if (state->tick > answered_tick_) decide(*state);
    if (answer_count_ > 0) lcm_.publish("UNLATCH_COMMAND", &answer_);
    unlatch::StepAck ack{};
    ack.session = session_;
    ack.sequence = state->sequence;
    ack.tick = state->tick;
    ack.last_command = last_command_;
    ack.participant = kParticipant;
    ack.command_count = answer_count_;
    lcm_.publish("UNLATCH_STEP_ACK", &ack);
  }

  // The task of flight software: a decision from a state.
  void decide(const unlatch::State& state) {
    answered_tick_ = state.tick;
    answer_count_ = state.tick == kOpenAt || state.tick == kShutAt ? 1 : 0;
    answer_.session = session_;
    answer_.sequence = last_command_ += answer_count_;
    answer_.tick = state.tick;
    answer_.valid_until_tick = -1;
    answer_.value = state.tick == kOpenAt ? 1 : 0;
    answer_.participant = kParticipant;
    answer_.channel = throttle_;
  }

  lcm::LCM& lcm_;
  std::int64_t session_ = 0;   // 0: none yet
  std::int64_t heard_us_ = 0;  // time at which something of it came last
  bool warned_ = false;          // of another simulator
  int throttle_ = -1;          // the channel's index
  unlatch::HelloAck introduction_{};
  std::int64_t answered_tick_ = -1, last_command_ = 0;
  unlatch::Command answer_{};  // the command of answered_tick_
  int answer_count_ = 0;
  unlatch::State end_{};
};

}  // namespace

int main() {
  lcm::LCM lcm("udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) {
    std::fprintf(stderr, "pilot: LCM does not open; is there a route for multicast?\n");
    return 3;
  }
  Pilot pilot(lcm);
  while (!pilot.has_ended()) {
    if (lcm.handleTimeout(kPatience_ms) <= 0) {
      std::fprintf(stderr, "pilot: the simulator is silent\n");
      return 1;
    }
  }
  const unlatch::State& end = pilot.get_end();
  std::printf("pilot: the session ended at tick %lld, x = %.6f m\n", static_cast<long long>(end.tick), end.bodies[0].x);
  return end.status == unlatch::State::RunStatus_kDone ? 0 : 1;
}
