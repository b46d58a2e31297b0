#include "hil/run/recording/recorder.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>

#include "hil/session/realtime/nonblocking.h"

namespace unlatch::hil {
namespace {

using namespace std::chrono_literals;

constexpr auto kLook = 5ms;              // interval of emptying the rings
constexpr auto kFlush = 100ms;           // greatest loss of a killed process
constexpr double kStateInterval = 0.01;  // s of simulated time between recorded State messages
constexpr auto kWaitForRoom = std::chrono::microseconds(50);

std::int64_t calc_state_every(const std::string& path, double dt) {
  if (path.empty()) return 0;
  return std::max<std::int64_t>(1, std::llround(kStateInterval / dt));
}

// Touches all of a ring's memory, so that the cyclic thread meets no page for the first time, and a recording's peak of
// memory does not depend on how far its thread once fell behind.
template <class T>
void touch(moodycamel::BlockingReaderWriterCircularBuffer<T>& ring) {
  T item{};
  while (ring.try_enqueue(item)) {
  }
  while (ring.try_dequeue(item)) {
  }
}

}  // namespace

Recorder::Recorder(const std::string& path, const LogHeader& header, std::size_t capacity)
    : may_wait_(header.pace != Pace::kRealtime),
      us_per_tick_(header.dt * 1e6),
      state_every_(calc_state_every(path, header.dt)),
      items_(capacity),
      writer_(path) {
  touch(items_);
  touch(states_);
  encode(header, buffer_);
  writer_.append(0, kHeaderChannel, buffer_);
  if (!writer_.flush()) throw LogWriteError(writer_.get_error());
  thread_ = std::jthread([this](const std::stop_token& stopping) { run(stopping); });
}

Recorder::~Recorder() = default;

bool Recorder::push(const Item& item) noexcept {
  while (!items_.try_enqueue(item)) {
    if (!may_wait_) {
      ++items_lost_;
      return false;
    }
    const MayWait not_in_real_time;
    std::this_thread::sleep_for(kWaitForRoom);
  }
  return true;
}

// The recorder's thread frees the slots of earlier ticks alone: parts of one tick beyond the ring's capacity are lost.
void Recorder::state(const StateMessage& part) noexcept {
  while (!states_.try_enqueue(part)) {
    if (!may_wait_ || states_of_tick_ == static_cast<std::int32_t>(kStateCapacity)) {
      ++states_lost_;
      return;
    }
    const MayWait not_in_real_time;
    std::this_thread::sleep_for(kWaitForRoom);
  }
  ++states_of_tick_;
}

void Recorder::tick(std::int64_t tick, std::int64_t hash) noexcept {
  if (push(Mark{tick, hash, items_lost_, states_of_tick_})) states_of_tick_ = 0;  // else the next mark's
}

void Recorder::run(const std::stop_token& stopping) {
  std::mutex mutex;  // mutex of the wait between two looks, which a stop ends
  std::condition_variable_any stop;
  std::unique_lock lock(mutex);
  auto flushed = std::chrono::steady_clock::now();
  bool clean = true;
  while (!stopping.stop_requested()) {
    if (drain()) clean = false;
    note_failure();
    const auto now = std::chrono::steady_clock::now();
    if (!clean && now - flushed >= kFlush) {
      writer_.flush();
      flushed = now;
      clean = true;
    }
    stop.wait_for(lock, stopping, kLook, [] { return false; });
  }
  drain();
}

bool Recorder::drain() {
  Item item;
  bool any = false;
  while (items_.try_dequeue(item)) {
    write(item);
    any = true;
  }
  return any;
}

template <class M>
void Recorder::write_message(const M& message) {
  std::array<std::uint8_t, kMaxWireBytes> bytes;
  const std::size_t length = encode(message, bytes);
  const auto timestamp = std::llround(static_cast<double>(message.tick) * us_per_tick_);
  writer_.append(timestamp, get_channel(Message(message).kind), {bytes.data(), length});
}

void Recorder::write(const Item& item) {
  if (const auto* change = std::get_if<LogChange>(&item)) {
    record_.changes.push_back(*change);
  } else if (const auto* received = std::get_if<LogReceived>(&item)) {
    record_.received.push_back(*received);
  } else if (const auto* event = std::get_if<EventMessage>(&item)) {
    write_message(*event);
  } else if (const auto* timing = std::get_if<TickTiming>(&item)) {
    encode(*timing, buffer_);
    writer_.append(std::llround(static_cast<double>(timing->tick) * us_per_tick_), kTimingChannel, buffer_);
  } else {
    const Mark& mark = std::get<Mark>(item);
    StateMessage part;
    for (std::int32_t i = 0; i < mark.states && states_.try_dequeue(part); ++i) write_message(part);
    record_.tick = mark.tick;
    record_.hash = mark.hash;
    record_.unrecorded = mark.lost;
    encode(record_, buffer_);
    writer_.append(std::llround(static_cast<double>(mark.tick) * us_per_tick_), kTickChannel, buffer_);
    record_.changes.clear();
    record_.received.clear();
  }
}

void Recorder::close(LogEnd& end) {
  thread_.request_stop();
  thread_.join();
  end.unrecorded = items_lost_;
  end.states_unrecorded = states_lost_;
  StateMessage part;
  while (states_.try_dequeue(part)) write_message(part);  // parts of the last tick, without a step after it
  encode(end, buffer_);
  writer_.append(std::llround(static_cast<double>(end.tick) * us_per_tick_), kEndChannel, buffer_);
  writer_.flush();
}

}  // namespace unlatch::hil
