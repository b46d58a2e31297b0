// The in-process transport: a list of bounded queues, one per port, and a publish that copies into those it concerns.
#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "bridge/core/port.h"

namespace unlatch::bridge {
namespace {

// The newest messages up to the capacity; memory is allocated once.
class Queue {
 public:
  Queue(Role role, std::size_t capacity) : role_(role), ring_(capacity) {}

  [[nodiscard]] Role get_role() const { return role_; }

  void push(const Message& message) {
    {
      const std::lock_guard lock(mutex_);
      if (count_ == ring_.size()) {
        first_ = (first_ + 1) % ring_.size();
        --count_;
        ++lost_;
      }
      if (count_ == 0) first_ = 0;  // a short queue stays in the cache
      ring_[(first_ + count_++) % ring_.size()] = message;
    }
    ready_.notify_one();
  }

  bool pop(Message& message, std::chrono::nanoseconds wait) {
    std::unique_lock lock(mutex_);
    if (count_ ==
        0) {  // not to wait is not to wait for 0 ns: that sleeps for as long as the kernel's timers are coarse
      if (wait <= std::chrono::nanoseconds::zero()) return false;
      if (!ready_.wait_for(lock, wait, [this] { return count_ > 0; })) return false;
    }
    message = ring_[first_];
    first_ = (first_ + 1) % ring_.size();
    --count_;
    return true;
  }

  [[nodiscard]] std::int64_t get_lost() const {
    const std::lock_guard lock(mutex_);
    return lost_;
  }

 private:
  const Role role_;
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::vector<Message> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::int64_t lost_ = 0;
};

}  // namespace

struct InprocHub::Shared {
  explicit Shared(std::size_t queue_capacity) : capacity(std::max<std::size_t>(queue_capacity, 1)) {}

  const std::size_t capacity;
  std::mutex mutex;
  std::vector<Queue*> queues;  // of the ports that are open
};

namespace {

class InprocPort final : public Port {
 public:
  InprocPort(Role role, std::shared_ptr<InprocHub::Shared> shared)
      : Port(role), shared_(std::move(shared)), queue_(role, shared_->capacity) {
    const std::lock_guard lock(shared_->mutex);
    shared_->queues.push_back(&queue_);
  }
  ~InprocPort() override {
    const std::lock_guard lock(shared_->mutex);
    std::erase(shared_->queues, &queue_);
  }

 private:
  bool send(const Message& message) override {
    const std::lock_guard lock(shared_->mutex);
    for (Queue* queue : shared_->queues) {
      if (queue != &queue_ && receives(queue->get_role(), message.kind)) queue->push(message);
    }
    return true;
  }

  Received receive(Message& message, std::chrono::nanoseconds wait) override {
    return queue_.pop(message, wait) ? Received::kMessage : Received::kNothing;
  }

  [[nodiscard]] std::int64_t get_lost() const override { return queue_.get_lost(); }

  const std::shared_ptr<InprocHub::Shared> shared_;
  Queue queue_;
};

}  // namespace

InprocHub::InprocHub(std::size_t capacity) : shared_(std::make_shared<Shared>(capacity)) {}
InprocHub::~InprocHub() = default;

std::unique_ptr<Port> InprocHub::open(Role role) { return std::make_unique<InprocPort>(role, shared_); }

}  // namespace unlatch::bridge
