#include "tools/fsw/participant.h"

#include <chrono>
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

// Another number for every start: the simulator tells two of one name apart by it.
std::int32_t draw_id() { return static_cast<std::int32_t>(std::random_device{}() >> 1); }

}  // namespace

ParticipantClient::ParticipantClient(bridge::Port& port, const std::string& name)
    : port_(port), name_(name), id_(draw_id()) {}

ParticipantClient::Outcome ParticipantClient::run(double patience_s, const std::atomic<bool>& stop) {
  Outcome outcome;
  auto heard = Clock::now();
  hil::Message message;
  while (!stop.load(std::memory_order_relaxed)) {
    if (!port_.poll(message, kPollWait)) {
      if (std::chrono::duration<double>(Clock::now() - heard).count() < patience_s) continue;
      outcome.explanation = session_ == 0 ? "no simulator was found" : "the simulator has stopped sending";
      return outcome;
    }
    if (message.kind == MessageKind::kHello) {
      hear_hello(message.hello);
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
    if (!refusal_.empty()) {
      outcome.explanation = refusal_;
      return outcome;
    }
  }
  if (attached_) say(AckStatus::kLeaving);
  outcome.explanation = "stopped";
  return outcome;
}

void ParticipantClient::hear_hello(const hil::HelloMessage& hello) {
  if (hello.session == session_) return;  // said again
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
}

// Once the catalog is complete, and again whenever the simulator says hello again.
void ParticipantClient::answer_hello() {
  if (session_ == 0 || !vehicle_.is_known() || !refusal_.empty()) return;
  if (!attached_) {
    const std::string missing = sequence_.attach(vehicle_);
    if (!missing.empty()) return refuse("the vehicle lacks " + missing);
    attached_ = true;
  }
  say(AckStatus::kReady);
}

// Of refusals only this one concerns a person: two computers were started with one name. We stay, in case the other
// goes.
void ParticipantClient::hear_verdict(const hil::VerdictMessage& verdict) {
  if (verdict.participant != id_ || verdict.reason != static_cast<int>(hil::Reject::kNameTaken) || told_) return;
  told_ = true;
  std::fprintf(stderr,
               "unlatch-fsw: another participant named '%s' takes part already; give each its own --name, or end the "
               "other one\n",
               name_.c_str());
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
  if (state.tick > answered_tick_) {
    commands_.clear();
    sequence_.update(state.time_ns, vehicle_, commands_);
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
  answer(state);
}

void ParticipantClient::answer(const hil::StateMessage& state) {
  for (const hil::CommandMessage& command : answer_commands_) port_.publish(command);
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
