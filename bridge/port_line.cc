#include "bridge/port_line.h"

#include <chrono>

namespace unlatch::bridge {
namespace {

std::int64_t get_now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

bool PortLine::send(const Message& message) noexcept { return port_.publish(message); }

bool PortLine::receive(Message& message, std::int64_t& arrived_ns) noexcept {
  if (is_awaited_) {
    message = awaited_;
    arrived_ns = arrived_ns_;
    is_awaited_ = false;
    return true;
  }
  if (!port_.poll(message, std::chrono::nanoseconds::zero())) return false;
  arrived_ns = get_now_ns();
  return true;
}

void PortLine::wait(std::chrono::nanoseconds limit) noexcept {
  if (is_awaited_) return;
  is_awaited_ = port_.poll(awaited_, limit);
  arrived_ns_ = get_now_ns();
}

}  // namespace unlatch::bridge
