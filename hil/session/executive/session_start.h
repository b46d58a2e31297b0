// The start of a session, before its clock: no other simulator is here, the required flight software introduces itself,
// and it answers State 0. The start is not in the cycle: it sleeps, allocates and waits.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "hil/session/executive/executive_options.h"
#include "hil/session/executive/session.h"

namespace unlatch::hil {

class SessionStart {
 public:
  // `stop`: set, the run ends. `begin_faults` begins the faults of tick 0, before its State. All but the latter must
  // outlive the start.
  SessionStart(Session& session, const ExecutiveOptions& options, const std::atomic<bool>& stop,
               std::function<void()> begin_faults)
      : session_(session), options_(options), stop_(stop), begin_faults_(std::move(begin_faults)) {}

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
  [[nodiscard]] const HelloMessage& get_other() const noexcept { return session_.get_other(); }
  [[nodiscard]] bool is_stopped() const noexcept { return stop_.load(std::memory_order_relaxed); }
  // Takes in the messages that have arrived, then sleeps.
  void poll() const;

  Session& session_;
  const ExecutiveOptions& options_;
  const std::atomic<bool>& stop_;
  const std::function<void()> begin_faults_;
};

}  // namespace unlatch::hil
