// The smallest stand-in for what F´'s autocoder writes from UnlatchSim.fpp, and for the types that it uses, by the
// published interface (F´ 3, Apache-2.0): names and meanings, no code of it. Ports are functions that the test sets.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>

using I32 = std::int32_t;
using I64 = std::int64_t;
using U16 = std::uint16_t;
using U32 = std::uint32_t;
using F64 = double;
using FwIndexType = std::int16_t;

namespace Fw {
class StringBase {
 public:
  virtual ~StringBase() = default;
  virtual const char* toChar() const = 0;
};
class String : public StringBase {
 public:
  explicit String(const char* text) : text_(text) {}
  const char* toChar() const override { return text_.c_str(); }

 private:
  std::string text_;
};
}  // namespace Fw

namespace Unlatch {

class SensorValues {
 public:
  enum { SIZE = 64 };
  F64& operator[](U32 i) { return values_[i]; }
  const F64& operator[](U32 i) const { return values_[i]; }

 private:
  std::array<F64, SIZE> values_{};
};

class UnlatchSimComponentBase {
 public:
  using StateOut = std::function<void(I64 tick, I64 time_ns, U32 count, SensorValues& values)>;
  explicit UnlatchSimComponentBase(const char*) {}
  virtual ~UnlatchSimComponentBase() = default;

  void set_stateOut(StateOut to) { stateOut_ = std::move(to); }
  void call_schedIn(U32 context) { schedIn_handler(0, context); }
  void call_commandIn(const char* channel, F64 value) { commandIn_handler(0, Fw::String(channel), value); }
  int warnings = 0;

 protected:
  virtual void schedIn_handler(FwIndexType portNum, U32 context) = 0;
  virtual void commandIn_handler(FwIndexType portNum, const Fw::StringBase& channel, F64 value) = 0;
  bool isConnected_stateOut_OutputPort(FwIndexType) const { return static_cast<bool>(stateOut_); }
  void stateOut_out(FwIndexType, I64 tick, I64 time_ns, U32 count, SensorValues& values) const {
    stateOut_(tick, time_ns, count, values);
  }
  void log_ACTIVITY_HI_SessionEnded(I64 tick) const {
    std::printf("UnlatchSim: the session ended at tick %lld\n", static_cast<long long>(tick));
  }
  void log_WARNING_HI_Refused(I32 reason) {
    std::printf("UnlatchSim: refused, reason %d\n", reason);
    ++warnings;
  }
  void log_WARNING_HI_UnknownChannel(const Fw::StringBase& channel) {
    std::printf("UnlatchSim: no channel %s\n", channel.toChar());
    ++warnings;
  }

 private:
  StateOut stateOut_;
};

}  // namespace Unlatch
