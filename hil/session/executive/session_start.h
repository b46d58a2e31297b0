// The start of a session, before its clock: no other simulator is here, the required flight software introduces itself,
// and it answers State 0. The start is not in the cycle: it sleeps, allocates and waits.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "hil/session/executive/reception.h"
#include "hil/session/executive/state_exchange.h"
#include "hil/session/participants/announcer.h"
#include "hil/session/participants/handshake.h"
#include "hil/session/participants/liveness.h"
#include "hil/session/participants/participants.h"
#include "hil/session/participants/session_options.h"
#include "hil/session/realtime/clock.h"

namespace unlatch::hil {

class SessionStart {
 public:
  // Parts of the session; all must outlive the start.
  struct Parts {
    const SessionOptions& options;
    const Clock& clock;
    Announcer& announcer;
    const Handshake& handshake;
    const Participants& participants;
    Liveness& liveness;
    StateExchange& exchange;
    Reception& reception;
    const std::atomic<bool>& stop;       // set: the run ends
    std::function<void()> begin_faults;  // faults of tick 0, before its State
    std::int64_t timeout_ns;             // limit for introductions, and for answers
    std::int64_t resend_ns;              // interval of States without an answer
  };

  explicit SessionStart(const Parts& parts) : parts_(parts) {}

  // Listens, introduces, exchanges State 0, whose hash is `hash`. Returns the reason why the session cannot start, none
  // if it can.
  [[nodiscard]] std::optional<std::string> run(std::int64_t hash) const;

 private:
  [[nodiscard]] std::optional<std::string> listen() const;
  [[nodiscard]] std::optional<std::string> introduce() const;
  [[nodiscard]] std::optional<std::string> exchange_first_state(std::int64_t hash) const;
  [[nodiscard]] bool wait_for_introductions(std::int64_t deadline_ns) const;
  // Another simulator is here, and this one may not start beside it.
  [[nodiscard]] bool is_disturbed() const noexcept;
  [[nodiscard]] bool gives_way() const noexcept;
  [[nodiscard]] std::string describe_other() const;
  [[nodiscard]] const HelloMessage& get_other() const noexcept { return parts_.reception.get_other(); }
  [[nodiscard]] bool is_stopped() const noexcept { return parts_.stop.load(std::memory_order_relaxed); }
  // Takes in the messages that have arrived, then sleeps.
  void poll() const;

  const Parts parts_;
};

}  // namespace unlatch::hil
