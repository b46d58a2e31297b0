#include "hil/session/executive/session_start.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kHelloInterval_ns = 100'000'000;
constexpr std::int64_t kPoll_ns = 1'000'000;  // sleep between two calls of receive()
constexpr const char* kInterrupted = "interrupted";

}  // namespace

std::optional<std::string> SessionStart::run(std::int64_t hash) const {
  if (auto failure = listen()) return failure;
  if (auto failure = introduce()) return failure;
  return exchange_first_state(hash);
}

void SessionStart::poll() const {
  session_.receive();
  session_.clock().sleep_until_ns(session_.clock().get_ns() + kPoll_ns);
}

// --- No other simulator is here -------------------------------------------------------------------------------------

std::optional<std::string> SessionStart::listen() const {
  const std::int64_t end_ns = session_.clock().get_ns() + options_.listen_ns;
  while (session_.clock().get_ns() < end_ns && !is_disturbed() && !is_stopped()) poll();
  if (!is_disturbed()) return std::nullopt;
  return describe_other();
}

// One session number is never for two: their flight software would answer both.
bool SessionStart::is_disturbed() const noexcept {
  if (session_.is_number_taken()) return true;
  return get_other().session != 0 && !options_.beside_others;
}

// The session with the larger number, of two that begin at the same time; both, if they have one number.
bool SessionStart::gives_way() const noexcept {
  if (!is_disturbed()) return false;
  return session_.is_number_taken() || get_other().status != static_cast<std::int32_t>(RunStatus::kDiscover) ||
         get_other().session < options_.session;
}

std::string SessionStart::describe_other() const {
  return "another simulator is here: scenario '" + std::string(get_name(get_other().scenario)) + "', session " +
         std::to_string(get_other().session) +
         (session_.is_number_taken() ? ", which is the number of this one too" : "") +
         "; flight software would not know which of them it belongs to. End it, use another network (--domain; LCM: "
         "the port in --lcm-url), or give this one and its flight software "
         "a --session NUMBER of their own";
}

// --- The flight software introduces itself --------------------------------------------------------------------------

std::optional<std::string> SessionStart::introduce() const {
  const std::int64_t give_up_ns = session_.clock().get_ns() + options_.start_timeout_ns;
  do {
    if (is_stopped()) return kInterrupted;
    session_.announcer().send_all();
    if (wait_for_introductions(session_.clock().get_ns() + kHelloInterval_ns)) {
      session_.announcer().set_status(RunStatus::kConfigured);
      return std::nullopt;
    }
    if (gives_way()) return describe_other();
    if (!session_.handshake().get_refusal().empty()) return session_.handshake().get_refusal();
  } while (session_.clock().get_ns() < give_up_ns);
  const auto is_absent = [](const Participant& participant) { return !participant.is_present(); };
  return "no answer from the flight software " + session_.participants().list_required(is_absent) + " within " +
         std::to_string(options_.start_timeout_ns / 1'000'000'000) +
         " s: start it on the same transport, with the name that the scenario requires";
}

bool SessionStart::wait_for_introductions(std::int64_t deadline_ns) const {
  const auto is_refused = [this] { return !session_.handshake().get_refusal().empty() || gives_way(); };
  while (!session_.participants().is_complete() && !is_refused() && session_.clock().get_ns() < deadline_ns) poll();
  return session_.participants().is_complete() && !is_refused();
}

// --- State 0 is answered --------------------------------------------------------------------------------------------

// State 0 is sent until all required participants have answered it, so that each topic is known to work in both
// directions before the clock starts.
std::optional<std::string> SessionStart::exchange_first_state(std::int64_t hash) const {
  const std::int64_t give_up_ns = session_.clock().get_ns() + options_.start_timeout_ns;
  begin_faults_();
  session_.exchange().publish(RunStatus::kConfigured, hash);
  while (session_.receive(), !session_.exchange().is_answered(session_.clock().get_ns())) {
    if (is_stopped()) return kInterrupted;
    const std::int64_t now_ns = session_.clock().get_ns();
    if (now_ns > give_up_ns || !session_.participants().is_complete()) {
      const auto owes_answer = [](const Participant& participant) { return !participant.has_answered(0); };
      return "the flight software " + session_.participants().list_required(owes_answer) +
             " has introduced itself, but does not answer State 0: does it receive the State and send StepAck?";
    }
    session_.announcer().announce(now_ns);
    if (now_ns - session_.exchange().get_quiet_since_ns(*session_.liveness().get_sent_ns()) >= options_.resend_ns) {
      session_.exchange().repeat(RunStatus::kConfigured);
      session_.liveness().restart_round_trip(now_ns);
    }
    session_.clock().sleep_until_ns(now_ns + kPoll_ns);
  }
  return std::nullopt;
}

}  // namespace unlatch::hil
