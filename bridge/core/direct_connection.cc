#include "bridge/core/direct_connection.h"

#include <utility>

namespace unlatch::bridge {

bool DirectConnection::send(const Message& message) noexcept { return port_.publish(message); }

bool DirectConnection::receive(hil::Arrival& arrival) noexcept {
  while (true) {
    const bool awaited = std::exchange(is_awaited_, false);
    if (!awaited && !port_.poll(message_, std::chrono::nanoseconds::zero())) return false;
    const auto message = hil::to_participant_message(message_);
    if (!message) continue;  // no port of this role receives another kind
    arrival = {*message, awaited ? awaited_ns_ : clock_.get_ns()};
    return true;
  }
}

void DirectConnection::wait(std::chrono::nanoseconds limit) noexcept {
  if (is_awaited_) return;
  is_awaited_ = port_.poll(message_, limit);
  awaited_ns_ = clock_.get_ns();
}

}  // namespace unlatch::bridge
