// A flight computer for tests: it uses the protocol of hil/PROTOCOL.md over a port, in a separate thread, and can be
// configured to leave, to stop, or to send wrong messages.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bridge/core/port.h"

namespace unlatch::test {

class Computer {
 public:
  struct Habits {
    std::int32_t id = 1;
    // Returns channel and value of each command for a tick.
    std::function<std::vector<std::pair<int, double>>(std::int64_t tick)> program = nullptr;
    // Returns the tick at which command `place` of such a program acts; null: the tick of the State that it answers.
    std::function<std::int64_t(std::size_t place)> due = nullptr;
    std::chrono::microseconds pace{0};  // time for an answer
    std::int64_t leaves_at = -1;        // announces it, and stops answering
    std::int64_t dies_at = -1;          // stops answering
    // Called once for each tick, before its answer.
    std::function<void(const hil::StateMessage& state, Computer& computer)> mischief = nullptr;
  };

  Computer(std::unique_ptr<bridge::Port> port, std::string name, Habits habits)
      : port_(std::move(port)), name_(std::move(name)), habits_(std::move(habits)) {
    thread_ = std::jthread([this](const std::stop_token& stopping) {
      hil::Message message;
      while (!stopping.stop_requested()) {
        if (port_->poll(message, std::chrono::milliseconds(5))) hear(message);
      }
    });
  }

  hil::CommandMessage make_command(std::int64_t tick, int channel, double value) {
    hil::CommandMessage command;
    command.session = session_;
    command.sequence = ++sequence_;
    command.tick = tick;
    command.valid_until_tick = -1;
    command.value = value;
    command.participant = habits_.id;
    command.channel = channel;
    return command;
  }
  void say(const hil::Message& message) { port_->publish(message); }
  [[nodiscard]] std::int64_t get_tick() const { return tick_.load(); }
  void stop() { thread_ = {}; }

  // Results, valid after stop().
  std::vector<hil::VerdictMessage> verdicts;  // verdicts on messages of this computer
  std::int64_t commands_sent = 0;             // including those sent again
  hil::HealthMessage health;                  // the latest
  hil::HelloMessage hello;                    // the latest
  std::vector<hil::RunStatus> statuses;       // statuses of Hello up to Configured, then of State; each change

 private:
  static constexpr std::size_t kRepeatedWhole =
      64;  // commands of an answer; of longer ones the missing commands are repeated

  void hear(const hil::Message& message) {
    if (silent_) return;
    switch (message.kind) {
      case hil::MessageKind::kHello:
        hello = message.hello;
        note(hello.status);
        session_ = hello.session;
        return say_hello(hil::AckStatus::kReady);
      case hil::MessageKind::kState:
        if (message.state.part == 0 && message.state.session == session_) {
          note(message.state.status);
          hear_state(message.state);
        }
        return;
      case hil::MessageKind::kVerdict:
        if (message.verdict.participant != habits_.id) return;
        if (message.verdict.reason == static_cast<int>(hil::Reject::kMissing)) return send_missing(message.verdict);
        verdicts.push_back(message.verdict);
        return;
      case hil::MessageKind::kHealth:
        health = message.health;
        return;
      default:
        return;
    }
  }

  void send(const hil::CommandMessage& command) {
    say(command);
    ++commands_sent;
  }

  void send_missing(const hil::VerdictMessage& verdict) {
    for (const hil::CommandMessage& command : answer_) {
      const std::int64_t place = command.sequence - verdict.refers_to;
      if (place >= 0 && place < verdict.count) send(command);
    }
  }

  void note(std::int32_t number) {
    const auto status = static_cast<hil::RunStatus>(number);
    if (statuses.empty() || status > statuses.back()) statuses.push_back(status);
  }

  void say_hello(hil::AckStatus status) {
    hil::HelloAckMessage ack;
    ack.session = session_;
    ack.schema_hash = hil::kSchemaHash;
    ack.model_hash = hello.model_hash;
    ack.dt_ns = hello.dt_ns;
    ack.protocol = hil::kProtocolVersion;
    ack.participant = habits_.id;
    ack.status = static_cast<std::int32_t>(status);
    hil::set_name(ack.name, name_);
    say(ack);
  }

  void hear_state(const hil::StateMessage& state) {
    if (state.status >= static_cast<int>(hil::RunStatus::kDone)) return;
    if (habits_.dies_at >= 0 && state.tick >= habits_.dies_at) {
      silent_ = true;
      return;
    }
    if (habits_.leaves_at >= 0 && state.tick >= habits_.leaves_at) {
      silent_ = true;
      return say_hello(hil::AckStatus::kLeaving);
    }
    if (state.tick > tick_) {
      std::this_thread::sleep_for(habits_.pace);
      answer_.clear();
      tick_ = state.tick;
      if (habits_.mischief) habits_.mischief(state, *this);
      if (habits_.program) {
        for (const auto& [channel, value] : habits_.program(state.tick)) {
          const std::int64_t tick = habits_.due ? habits_.due(answer_.size()) : state.tick;
          answer_.push_back(make_command(tick, channel, value));
        }
      }
    }
    if (state.tick < tick_) return;
    const bool again = std::exchange(answered_, state.tick) == state.tick;
    if (!again || answer_.size() <= kRepeatedWhole) {
      for (const hil::CommandMessage& command : answer_) send(command);
    }
    hil::StepAckMessage ack;
    ack.session = session_;
    ack.sequence = state.sequence;
    ack.tick = state.tick;
    ack.last_command = sequence_;
    ack.participant = habits_.id;
    ack.command_count = static_cast<std::int32_t>(answer_.size());
    say(ack);
  }

  std::unique_ptr<bridge::Port> port_;
  const std::string name_;
  const Habits habits_;
  std::int64_t session_ = 0, sequence_ = 0;
  std::atomic<std::int64_t> tick_{-1};
  std::int64_t answered_ = -1;
  bool silent_ = false;
  std::vector<hil::CommandMessage> answer_;
  std::jthread thread_;
};

}  // namespace unlatch::test
