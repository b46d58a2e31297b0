// What the executive speaks through: it sends, looks for what has come, and in lockstep waits for it.
#pragma once

#include <chrono>
#include <cstdint>

#include "hil/messages/messages.h"

namespace unlatch::hil {

// Used by the cyclic thread alone, but for the counts.
class Line {
 public:
  virtual ~Line() = default;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  // False when it could not be sent, which is counted.
  virtual bool send(const Message& message) noexcept = 0;
  // False when nothing waits; `arrived_ns`: when it came, by CLOCK_MONOTONIC.
  virtual bool receive(Message& message, std::int64_t& arrived_ns) noexcept = 0;
  // Sleeps until something has come, at most for `limit`. In real time nobody calls it.
  virtual void wait(std::chrono::nanoseconds limit) noexcept = 0;

  // Messages that found no room. From any thread.
  [[nodiscard]] virtual std::int64_t get_dropped_out() const noexcept = 0;
  [[nodiscard]] virtual std::int64_t get_dropped_in() const noexcept = 0;
  // Messages that the bridge dropped because they were none of the schema's: it is the executive that tells of them.
  [[nodiscard]] virtual std::int64_t get_malformed() const noexcept = 0;

 protected:
  Line() = default;
};

}  // namespace unlatch::hil
