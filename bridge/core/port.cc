#include "bridge/core/port.h"

#include <algorithm>

namespace unlatch::bridge {

bool publishes(Role role, MessageKind kind) noexcept {
  if (role == Role::kObserver || hil::get_size(kind) == 0) return false;
  return hil::is_from_simulator(kind) == (role == Role::kSimulator);
}

bool receives(Role role, MessageKind kind) noexcept {
  if (role == Role::kSimulator && kind == MessageKind::kHello) return true;  // of another simulator
  if (role == Role::kParticipant && (kind == MessageKind::kReactions || kind == MessageKind::kSource)) return false;
  return hil::get_size(kind) > 0 && !publishes(role, kind);
}

bool Port::publish(const Message& message) {
  const bool sent = publishes(role_, message.kind) && send(message);
  (sent ? published_ : publish_failures_).fetch_add(1, std::memory_order_relaxed);
  return sent;
}

bool Port::poll(Message& message, std::chrono::nanoseconds wait) {
  using Clock = std::chrono::steady_clock;
  wait = std::min<std::chrono::nanoseconds>(wait, std::chrono::hours(24));  // so that no deadline overflows
  const auto deadline = Clock::now() + wait;
  while (true) {
    const Received result = receive(message, wait);
    if (result == Received::kNothing) return false;
    if (result == Received::kMessage && hil::is_well_formed(message)) {
      received_.fetch_add(1, std::memory_order_relaxed);
      return true;
    }
    if (result != Received::kOther) malformed_.fetch_add(1, std::memory_order_relaxed);
    wait = deadline - Clock::now();
    if (wait < std::chrono::nanoseconds::zero())
      return false;  // a flood of malformed messages does not block the caller for ever
  }
}

PortCounts Port::get_counts() const {
  const Losses losses = get_losses();
  return {published_.load(std::memory_order_relaxed),
          publish_failures_.load(std::memory_order_relaxed),
          received_.load(std::memory_order_relaxed),
          get_malformed(),
          losses.lost,
          losses.unfit};
}

}  // namespace unlatch::bridge
