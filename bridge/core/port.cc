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
  std::int64_t unfit = 0;
  for (const UnfitPeers& peers : list_unfit()) unfit += peers.count;
  return {published_.load(std::memory_order_relaxed),
          publish_failures_.load(std::memory_order_relaxed),
          received_.load(std::memory_order_relaxed),
          get_malformed(),
          get_lost(),
          unfit};
}

std::string describe(const UnfitPeers& peers) {
  const bool one = peers.count == 1;
  return "unlatch_" + std::string(hil::get_kind_name(peers.kind)) + ": " + std::to_string(peers.count) +
         (peers.read ? (one ? " reader" : " readers") : (one ? " writer" : " writers")) +
         (one ? " of another program does" : " of other programs do") + " not match (policy " +
         std::string(peers.policy) + "), and " +
         (peers.read ? (one ? "receives nothing" : "receive nothing") : (one ? "is not heard" : "are not heard")) +
         "; bridge/README.md lists the quality of service of each topic";
}

}  // namespace unlatch::bridge
