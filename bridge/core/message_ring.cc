#include "bridge/core/message_ring.h"

#include <algorithm>
#include <cstring>

namespace unlatch::bridge {

MessageRing::MessageRing(std::size_t bytes) : bytes_(bytes), scratch_(hil::kMaxWireBytes) {}

void MessageRing::write(const void* from, std::size_t length) {
  const auto* const source = static_cast<const std::uint8_t*>(from);
  const std::size_t at = (first_ + used_) % bytes_.size(), until_end = std::min(length, bytes_.size() - at);
  std::memcpy(bytes_.data() + at, source, until_end);
  if (length > until_end) std::memcpy(bytes_.data(), source + until_end, length - until_end);
  used_ += length;
}

void MessageRing::read(void* to, std::size_t length) {
  auto* const target = static_cast<std::uint8_t*>(to);
  const std::size_t until_end = std::min(length, bytes_.size() - first_);
  std::memcpy(target, bytes_.data() + first_, until_end);
  if (length > until_end) std::memcpy(target + until_end, bytes_.data(), length - until_end);
  first_ = (first_ + length) % bytes_.size();
  used_ -= length;
}

void MessageRing::push(hil::MessageKind kind, std::span<const std::uint8_t> data) {
  if (data.size() > scratch_.size()) data = {};  // too long for any kind: unreadable either way
  {
    const std::lock_guard lock(mutex_);
    const Head head{kind, static_cast<std::uint32_t>(data.size())};
    while (used_ + sizeof head + data.size() > bytes_.size()) {
      Head oldest;
      read(&oldest, sizeof oldest);
      first_ = (first_ + oldest.length) % bytes_.size();
      used_ -= oldest.length;
      ++lost_;
    }
    write(&head, sizeof head);
    if (!data.empty()) write(data.data(), data.size());
  }
  ready_.notify_one();
}

bool MessageRing::pop(hil::Message& message, bool& readable, std::chrono::nanoseconds wait) {
  Head head;
  {
    std::unique_lock lock(mutex_);
    if (used_ == 0) {  // not to wait is not to wait for 0 ns: that sleeps for as long as the kernel's timers are coarse
      if (wait <= std::chrono::nanoseconds::zero()) return false;
      if (!ready_.wait_for(lock, wait, [this] { return used_ > 0; })) return false;
    }
    read(&head, sizeof head);
    read(scratch_.data(), head.length);
  }
  readable = hil::decode(head.kind, std::span(scratch_).first(head.length), message);
  return true;
}

std::int64_t MessageRing::get_lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

}  // namespace unlatch::bridge
