// What waits for one client: bounded, so that a slow or stopped one costs no more than this, and delays nobody. What
// finds no place is dropped and counted.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

namespace unlatch::bridge {

struct Outgoing {
  std::shared_ptr<const std::string> bytes;
  bool is_text = false;  // of a WebSocket
};

class SendQueue {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 22;

  bool push(Outgoing item) {
    if (waiting_ + item.bytes->size() > kMostBytes) {
      ++dropped_;
      return false;
    }
    waiting_ += item.bytes->size();
    items_.push_back(std::move(item));
    return true;
  }
  [[nodiscard]] bool is_empty() const { return items_.empty(); }
  [[nodiscard]] const Outgoing& front() const { return items_.front(); }
  void pop() {
    waiting_ -= items_.front().bytes->size();
    items_.pop_front();
  }
  [[nodiscard]] std::int64_t get_dropped() const { return dropped_; }

 private:
  std::deque<Outgoing> items_;
  std::size_t waiting_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace unlatch::bridge
