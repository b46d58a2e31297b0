// Writer of a recording (hil/run/recording/log_format.h), with a thread of its own. The cyclic thread pushes into rings
// and never waits for the disk. In real time items that find a ring full are counted, and the recording is then not
// replayable; at other paces the cyclic thread waits for space in a ring.
#pragma once

#include <readerwriterqueue/readerwritercircularbuffer.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <variant>

#include "hil/run/recording/log_format.h"

namespace unlatch::hil {

class Recorder {
 public:
  // Writes the header. An empty path records into a nameless file without State messages, for looking at the run
  // afterwards. `capacity`: of the ring, in items. Throws LogWriteError.
  Recorder(const std::string& path, const LogHeader& header, std::size_t capacity = kCapacity);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Cyclic thread, in this order within a tick. No allocation; no system call in real time.
  [[nodiscard]] bool wants_state(std::int64_t tick) const noexcept {
    return state_every_ > 0 && tick % state_every_ == 0;
  }
  void state(const StateMessage& part) noexcept;
  void event(const EventMessage& event) noexcept { push(event); }
  void change(const LogChange& change) noexcept { push(change); }
  void received(const LogReceived& received) noexcept { push(received); }
  void timing(const TickTiming& timing) noexcept { push(timing); }
  void tick(std::int64_t tick, std::int64_t hash) noexcept;  // seals what came before

  // Writes the rest and the end, completes `end.unrecorded`. Any one thread, after the cyclic thread is done.
  void close(LogEnd& end);
  // True if nothing is recorded any more after an error of the file. Any thread.
  [[nodiscard]] bool has_failed() const noexcept { return failed_.load(std::memory_order_relaxed); }
  // Error of the file; empty if there was none. After close().
  [[nodiscard]] const std::string& get_error() const { return writer_.get_error(); }
  // Stream of a nameless recording, to be read while the recorder lives. After close().
  [[nodiscard]] std::FILE* rewind() { return writer_.rewind(); }

 private:
  static constexpr std::size_t kCapacity = 8192, kStateCapacity = 256;
  struct Mark {
    std::int64_t tick, hash, lost;
    std::int32_t states;  // State messages in the other ring that belong before it
  };
  using Item = std::variant<Mark, LogChange, LogReceived, EventMessage, TickTiming>;

  bool push(const Item& item) noexcept;
  void run(const std::stop_token& stopping);
  void note_failure() { failed_.store(!writer_.get_error().empty(), std::memory_order_relaxed); }
  bool drain();
  void write(const Item& item);
  template <class M>
  void write_message(const M& message);

  const bool may_wait_;
  const double us_per_tick_;
  std::int64_t state_every_ = 0;  // ticks

  moodycamel::BlockingReaderWriterCircularBuffer<Item> items_;
  moodycamel::BlockingReaderWriterCircularBuffer<StateMessage> states_{kStateCapacity};
  std::int32_t states_of_tick_ = 0;  // cyclic thread
  std::int64_t items_lost_ = 0;      // cyclic thread, until close()
  std::int64_t states_lost_ = 0;     // cyclic thread, until close(); a replay does not need them
  std::atomic<bool> failed_{false};

  LogFileWriter writer_;
  LogTick record_;                    // recorder thread
  std::vector<std::uint8_t> buffer_;  // recorder thread
  std::jthread thread_;
};

}  // namespace unlatch::hil
