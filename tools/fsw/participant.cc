#include "tools/fsw/participant.h"

#include <algorithm>
#include <cstdio>
#include <random>

namespace unlatch::fsw {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
using hil::AckStatus;
using hil::MessageKind;
using hil::RunStatus;

constexpr auto kPollWait = 50ms;

// A simulator sends something every few milliseconds. When ours has been silent for so long and another one is heard,
// it is gone. Only time in which we listened counts: this process may have been stopped.
constexpr auto kGone = 2s;
constexpr auto kMostOfALook = 100ms;

// Answers of at most so many commands are repeated as a whole; of longer ones what the simulator says is missing.
constexpr std::size_t kRepeatedWhole = 64;

// Another number for every start: the simulator distinguishes two of one name by it.
std::int32_t draw_id() { return static_cast<std::int32_t>(std::random_device{}() >> 1); }

}  // namespace

ParticipantClient::ParticipantClient(bridge::Port& port, ControlLaw& law, const std::string& name, std::int64_t session)
    : port_(port), law_(law), name_(name), id_(draw_id()), wanted_session_(session) {}

ParticipantClient::Outcome ParticipantClient::run(double patience_s, const std::atomic<bool>& stop) {
  Outcome outcome;
  auto heard = Clock::now(), looked = heard;
  hil::Message message;
  while (!stop.load(std::memory_order_relaxed)) {
    const auto now = Clock::now();
    silence_ += std::min<std::chrono::nanoseconds>(now - looked, kMostOfALook);
    looked = now;
    if (!port_.poll(message, kPollWait)) {
      if (std::chrono::duration<double>(Clock::now() - heard).count() < patience_s) continue;
      outcome.explanation = session_ == 0 ? "no simulator was found" : "the simulator has stopped sending";
      return outcome;
    }
    if (message.kind == MessageKind::kHello) {
      if (!hear_hello(message.hello)) continue;
      answer_hello();
    } else if (message.kind == MessageKind::kCatalog && message.catalog.session == session_) {
      vehicle_.learn(message.catalog);
      if (!attached_) answer_hello();
    } else if (message.kind == MessageKind::kVerdict && message.verdict.session == session_) {
      hear_verdict(message.verdict);
    } else if (message.kind == MessageKind::kState && message.state.session == session_ && session_ != 0) {
      hear_state(message.state);
      if (has_ended(message.state, outcome)) return outcome;
    } else {
      continue;  // another session, or nothing that concerns us
    }
    heard = Clock::now();
    silence_ = 0ns;
    if (!refusal_.empty()) {
      outcome.explanation = refusal_;
      return outcome;
    }
  }
  if (attached_) say(AckStatus::kLeaving);
  outcome.explanation = "stopped";
  return outcome;
}

bool ParticipantClient::hear_hello(const hil::HelloMessage& hello) {
  if (hello.session == session_) return true;                                     // said again
  if (hello.status >= static_cast<std::int32_t>(RunStatus::kDone)) return false;  // kept from a session that is over
  if (wanted_session_ != 0 && hello.session != wanted_session_) return false;
  if (session_ != 0 && silence_ < kGone) {
    tell_of_other(hello);
    return false;
  }
  session_ = hello.session;
  agreed_ = hil::HelloAckMessage{};
  agreed_.session = hello.session;
  agreed_.schema_hash = hil::kSchemaHash;
  agreed_.model_hash = hello.model_hash;
  agreed_.dt_ns = hello.dt_ns;
  agreed_.protocol = hil::kProtocolVersion;
  agreed_.participant = id_;
  hil::set_name(agreed_.name, name_);
  attached_ = false;
  answered_tick_ = -1;
  last_command_ = 0;
  vehicle_.begin(hello);
  if (hello.schema_hash != hil::kSchemaHash || hello.protocol != hil::kProtocolVersion) {
    refuse("built for another version of the message schema");
  }
  return true;
}

void ParticipantClient::tell_of_other(const hil::HelloMessage& hello) {
  if (!others_heard_.is_news(hello.session)) return;
  std::fprintf(
      stderr,
      "unlatch-fsw: another simulator is heard, scenario '%s', session %lld; '%s' stays with session %lld. Choose "
      "one with --session\n",
      std::string(hil::get_name(hello.scenario)).c_str(), static_cast<long long>(hello.session), name_.c_str(),
      static_cast<long long>(session_));
}

// Once the catalog is complete, and again whenever the simulator says hello again.
void ParticipantClient::answer_hello() {
  if (session_ == 0 || !vehicle_.is_known() || !refusal_.empty()) return;
  if (!attached_) {
    const std::string missing = law_.attach(vehicle_);
    if (!missing.empty()) return refuse("the vehicle lacks " + missing);
    attached_ = true;
  }
  say(AckStatus::kReady);
}

// The only refusal that concerns a person is kNameTaken: two computers were started with one name. We stay, in case the
// other goes.
void ParticipantClient::hear_verdict(const hil::VerdictMessage& verdict) {
  if (verdict.participant != id_) return;
  if (verdict.reason == static_cast<int>(hil::Reject::kMissing)) return send_missing(verdict.refers_to, verdict.count);
  if (verdict.reason != static_cast<int>(hil::Reject::kNameTaken) || told_) return;
  told_ = true;
  std::fprintf(stderr,
               "unlatch-fsw: another participant named '%s' takes part already; give each its own --name, or end the "
               "other one\n",
               name_.c_str());
}

void ParticipantClient::send_missing(std::int64_t first, std::int64_t count) {
  for (const hil::CommandMessage& command : answer_commands_) {
    if (command.sequence >= first && command.sequence - first < count) port_.publish(command);
  }
}

void ParticipantClient::refuse(const std::string& reason) {
  refusal_ = reason;
  hil::set_name(agreed_.reason, reason);
  say(AckStatus::kRefused);
}

void ParticipantClient::say(AckStatus status) {
  agreed_.status = static_cast<std::int32_t>(status);
  port_.publish(agreed_);
  ++agreed_.sequence;
}

void ParticipantClient::hear_state(const hil::StateMessage& state) {
  if (!attached_ || state.tick < answered_tick_ || !vehicle_.sense(state)) return;
  const bool again = state.tick == answered_tick_;
  if (!again) {
    commands_.clear();
    law_.update(state.time_ns, vehicle_, commands_);
    answered_tick_ = state.tick;
    answer_commands_.clear();
    for (const Commands::Setting& setting : commands_.get()) {
      hil::CommandMessage command;
      command.session = session_;
      command.sequence = ++last_command_;
      command.tick = state.tick;
      command.valid_until_tick = -1;
      command.value = setting.value;
      command.participant = id_;
      command.channel = setting.channel;
      answer_commands_.push_back(command);
    }
  }
  answer(state, again);
}

void ParticipantClient::answer(const hil::StateMessage& state, bool again) {
  if (!again || answer_commands_.size() <= kRepeatedWhole) {
    for (const hil::CommandMessage& command : answer_commands_) port_.publish(command);
  }
  hil::StepAckMessage ack;
  ack.session = session_;
  ack.sequence = state.sequence;
  ack.tick = state.tick;
  ack.last_command = last_command_;
  ack.participant = id_;
  ack.command_count = static_cast<std::int32_t>(answer_commands_.size());
  port_.publish(ack);
}

bool ParticipantClient::has_ended(const hil::StateMessage& state, Outcome& outcome) const {
  switch (static_cast<RunStatus>(state.status)) {
    case RunStatus::kDone:
      outcome = {true, "the run is done"};
      return true;
    case RunStatus::kFaulted:
      outcome = {true, "the simulator reports a fault"};
      return true;
    case RunStatus::kAborted:
      outcome = {true, "the run was aborted"};
      return true;
    default:
      return false;
  }
}

}  // namespace unlatch::fsw
