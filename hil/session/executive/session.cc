#include "hil/session/executive/session.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "hil/session/messages/event_names.h"

namespace unlatch::hil {
namespace {

constexpr int kMaxArrivals = 512;  // limit of one call of receive(): bounds the work of a tick

std::vector<std::string> get_required(const SessionOptions& options) {
  return options.pace == Pace::kFast ? std::vector<std::string>{} : options.flight_software.required;
}

std::int64_t calc_horizon_ticks(const FlightSoftware& flight_software, const HelloMessage& hello) {
  constexpr double kMost = 0x1p53;
  return static_cast<std::int64_t>(
      std::min(std::ceil(flight_software.horizon * 1e9 / static_cast<double>(hello.dt_ns)), kMost));
}

Announcer build_announcer(const Simulation& simulation, const std::string& scenario, const ExecutiveOptions& options,
                          Connection& connection) {
  std::vector<CatalogMessage> catalog = build_session_catalog(simulation, options);
  const HelloMessage hello = build_hello(simulation, scenario, options, catalog);
  return {hello, std::move(catalog), options.source, connection, *options.clock, options.announce_ns};
}

}  // namespace

Session::Session(const Simulation& simulation, Connection& connection, Recorder& recorder, const std::string& scenario,
                 const ExecutiveOptions& options, Heartbeat& heartbeat, Histogram& round_trip)
    : simulation_(simulation),
      clock_(*options.clock),
      heartbeat_(heartbeat),
      number_(options.session),
      participants_(get_required(options)),
      faulty_connection_(options.faults == nullptr ? nullptr
                                                   : std::make_unique<FaultyConnection>(
                                                         connection, *options.faults, participants_, clock_,
                                                         [this](Participant& participant) { resume(participant); })),
      connection_(faulty_connection_ ? *faulty_connection_ : connection),
      announcer_(build_announcer(simulation, scenario, options, connection_)),
      handshake_(announcer_.get_hello(), participants_),
      liveness_(participants_, options.flight_software.policy, announcer_.get_hello().timeout_ns),
      commands_(simulation.model().channels,
                {.session = options.session,
                 .delay_ticks = options.flight_software.delay,
                 .accept_late = options.pace == Pace::kRealtime,
                 .horizon_ticks = calc_horizon_ticks(options.flight_software, announcer_.get_hello()),
                 .places = static_cast<std::size_t>(options.flight_software.queue)},
                participants_, rejects_),
      publisher_(simulation, recorder, connection_, options.faults, options.session),
      exchange_(simulation, clock_, participants_, liveness_, commands_, publisher_, round_trip) {}

void Session::receive() noexcept {
  const MayWait without_deadlines(!cutoff_ns_);
  heartbeat_.beat(RunPlace::kReceiving);
  for (int i = 0; i < kMaxArrivals && connection_.receive(arrival_); ++i) {
    std::visit([this](const auto& message) { handle(message, arrival_.arrived_ns); }, arrival_.message);
  }
  count_malformed();
}

void Session::count_malformed() noexcept {
  const std::int64_t malformed = connection_.get_malformed();
  if (malformed != malformed_) rejects_.add(Reject::kMalformed, malformed - malformed_);
  malformed_ = malformed;
}

void Session::handle(const HelloAckMessage& answer, std::int64_t) noexcept {
  const Handshake::Outcome outcome = handshake_.receive(answer, clock_.get_ns());
  if (outcome.reject) rejects_.add(*outcome.reject);
  if (outcome.verdict)
    publisher_.publish_verdict(*outcome.reject, get_name(answer.name), answer.participant, answer.sequence, -1, -1);
  if (outcome.restarted != nullptr) commands_.remove(*outcome.restarted);
  if (!outcome.notice.empty()) publisher_.publish_notice(outcome.notice, get_name(answer.name));
}

void Session::handle(const CommandMessage& command, std::int64_t arrived_ns) noexcept {
  Participant* const sender = command.session == number_ ? participants_.find(command.participant) : nullptr;
  if (sender != nullptr) resume(*sender);
  command_ns_ = arrived_ns;
  const bool in_time = !cutoff_ns_ || arrived_ns <= *cutoff_ns_;
  const std::int64_t tick = simulation_.get_tick();
  const CommandQueue::Outcome outcome = commands_.add(command, sender, in_time ? tick : tick + 1);
  if (outcome.repeated) return;
  const std::string_view from = sender != nullptr ? std::string_view(sender->name) : std::string_view();
  if (outcome.reason) {
    publisher_.publish_verdict(*outcome.reason, from, command.participant, command.sequence, command.channel,
                               outcome.applied_tick);
  }
  if (outcome.displaced) {
    publisher_.publish_verdict(Reject::kNoPlace, from, command.participant, outcome.displaced->sequence,
                               outcome.displaced->channel, -1);
  }
  const bool is_known = outcome.reason == Reject::kDuplicate || outcome.reason == Reject::kJump;
  if (sender != nullptr && !is_known) sender->news_ns = arrived_ns;
}

void Session::handle(const StepAckMessage& ack, std::int64_t arrived_ns) noexcept {
  if (ack.session != number_) return rejects_.add(Reject::kWrongSession);
  Participant* const sender = participants_.find(ack.participant);
  if (sender == nullptr || sender->standing == Participant::Standing::kEvicted) {
    return rejects_.add(Reject::kUnknownParticipant);
  }
  const bool sane = ack.tick >= 0 && ack.tick <= simulation_.get_tick() && ack.last_command >= 0 &&
                    ack.command_count >= 0 && ack.command_count <= SeenCommands::kWindow;
  if (!sane) return rejects_.add(Reject::kMalformed);
  resume(*sender);
  liveness_.receive(ack, *sender, arrived_ns, clock_.get_ns());
  exchange_.record_late_answers();
}

// A connection never gives back our own Hello. One simulator with our session number counts more than any other.
void Session::handle(const HelloMessage& other, std::int64_t) noexcept {
  const bool is_over = other.status >= static_cast<std::int32_t>(RunStatus::kDone);
  if (other.session == 0 || is_over) return;
  if (!is_number_taken()) other_ = other;
  if (reported_others_.is_news(other.session)) publisher_.publish_notice(kOtherSimulator, get_name(other.scenario));
}

void Session::resume(Participant& participant) noexcept {
  if (!liveness_.resume(participant, clock_.get_ns())) return;
  publisher_.publish_notice(kResumed, participant.name);
}

}  // namespace unlatch::hil
