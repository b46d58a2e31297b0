// Messages of participants to the cyclic executive, in real time and in lockstep, under every policy. No thread waits:
// the clock below jumps to every deadline, so that an execution is short and the same each time.
//
//   input  = choices (1 byte: bit 0 the pace, bit 7 a spin, the rest policy and delay), then the messages, item by item
//   item   = kind and marks (1 byte), the message's bytes (as many as its struct has, or what is left)
#include <algorithm>
#include <cstring>

#include "hil/session/executive/executive.h"
#include "hil/session/realtime/clock.h"
#include "tests/fuzz/fuzz.h"

using namespace unlatch;

namespace {

constexpr std::int64_t kLook_ns = 1000;
constexpr std::int32_t kComputer = 7;
constexpr std::int64_t kSession = 4711;
std::int64_t clock_ns = 0;

class JumpingClock final : public hil::Clock {
 public:
  [[nodiscard]] std::int64_t get_ns() const noexcept override { return clock_ns += kLook_ns; }
  void sleep_until_ns(std::int64_t deadline_ns) const noexcept override { clock_ns = std::max(clock_ns, deadline_ns); }
};

// Sends the initial messages of the flight software, then those of the input; before both the Hellos with which the
// input begins.
class FuzzConnection final : public hil::Connection {
 public:
  FuzzConnection(std::span<const std::uint8_t> script, std::int64_t model_hash)
      : script_(script), model_hash_(model_hash) {}

  bool send(const hil::Message& message) noexcept override {
    if (message.kind == hil::MessageKind::kState) tick_ = message.state.tick;
    fuzz::require(hil::is_well_formed(message), "a message of the simulator's that no port would let through");
    return true;
  }
  bool receive(hil::Arrival& arrival) noexcept override {
    arrival.arrived_ns = clock_ns;
    hil::Message message;
    if (said_ < 2 && !is_hello_next()) {
      if (said_++ == 0) {
        arrival.message = make_hello();
      } else {
        arrival.message = make_ack();
      }
      return true;
    }
    if (script_.empty()) return false;
    const std::uint8_t marks = script_[0];
    script_ = script_.subspan(1);
    if ((marks & 0x80) != 0) return false;  // the remaining messages come later
    switch (marks % 3) {
      case 0: {
        hil::CommandMessage command = take<hil::CommandMessage>();
        adapt(command, marks);
        message = command;
        break;
      }
      case 1: {
        hil::StepAckMessage ack = take<hil::StepAckMessage>();
        adapt(ack, marks);
        message = ack;
        break;
      }
      default: {
        if (is_hello(marks)) {  // of another simulator
          hil::HelloMessage hello = take<hil::HelloMessage>();
          if ((marks & 0x40) != 0) hello.session = kSession;
          message = hello;
          break;
        }
        hil::HelloAckMessage hello = take<hil::HelloAckMessage>();
        if ((marks & 0x40) != 0) hello = mix(make_hello(), hello);
        message = hello;
        break;
      }
    }
    if (!hil::is_well_formed(message)) return false;  // a port lets only well-formed messages through
    arrival.message = *hil::to_participant_message(message);
    return true;
  }
  void wait(std::chrono::nanoseconds limit) noexcept override { clock_ns += limit.count(); }
  [[nodiscard]] std::int64_t get_dropped_out() const noexcept override { return 0; }
  [[nodiscard]] std::int64_t get_dropped_in() const noexcept override { return 0; }
  [[nodiscard]] std::int64_t get_malformed() const noexcept override { return 0; }

 private:
  static bool is_hello(std::uint8_t marks) { return (marks & 0x88) == 0x08 && marks % 3 == 2; }
  [[nodiscard]] bool is_hello_next() const { return !script_.empty() && is_hello(script_[0]); }

  template <class T>
  T take() {
    T value{};
    const std::size_t size = std::min(script_.size(), sizeof value);
    if (size > 0) std::memcpy(static_cast<void*>(&value), script_.data(), size);
    script_ = script_.subspan(size);
    return value;
  }
  // Marks make a message one of this session, of the active computer, or of the present tick.
  template <class T>
  void adapt(T& message, std::uint8_t marks) const {
    if ((marks & 0x40) != 0) message.session = kSession;
    if ((marks & 0x20) != 0) message.participant = kComputer;
    if ((marks & 0x10) != 0) message.tick = tick_ + message.tick % 3;
  }
  [[nodiscard]] hil::HelloAckMessage make_hello() const {
    hil::HelloAckMessage hello;
    hello.session = kSession;
    hello.schema_hash = hil::kSchemaHash;
    hello.model_hash = model_hash_;
    hello.dt_ns = 1'000'000;
    hello.protocol = hil::kProtocolVersion;
    hello.participant = kComputer;
    hello.status = static_cast<std::int32_t>(hil::AckStatus::kReady);
    hil::set_name(hello.name, "fsw");
    return hello;
  }
  static hil::StepAckMessage make_ack() {
    hil::StepAckMessage ack;
    ack.session = kSession;
    ack.participant = kComputer;
    return ack;
  }
  // Agreed answer with another one's number, status and name.
  static hil::HelloAckMessage mix(hil::HelloAckMessage agreed, const hil::HelloAckMessage& other) {
    agreed.participant = other.participant % 4 + kComputer;
    agreed.status = other.status;
    if (other.name[0] != 0) agreed.name = other.name;
    return agreed;
  }

  std::span<const std::uint8_t> script_;
  const std::int64_t model_hash_;
  std::int64_t tick_ = 0;
  int said_ = 0;
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::size_t kRoom = 64;
  static const hil::Scenario scenario = hil::load_scenario_text(fuzz::kSmallScenario, "small.yaml");
  static const auto simulation = hil::build_simulation(scenario);
  static const auto beginning = simulation->save();
  fuzz::require(simulation->restore(beginning), "a simulation that does not go back to its beginning");
  clock_ns = -1'000'000;  // the session begins just before the clock reads 0

  const JumpingClock clock;
  hil::ExecutiveOptions options;
  options.clock = &clock;
  options.pace = (data[0] & 1) != 0 ? hil::Pace::kRealtime : hil::Pace::kLockstep;
  options.session = kSession;
  options.last_tick = 4;
  options.flight_software = scenario.flight_software;
  options.flight_software.queue = 16;      // the minimum: an input can fill it, and little memory is cleared for each
  options.start_timeout_ns = 100'000'000;  // time of the clock above; a hundred polls
  options.flight_software.policy = static_cast<hil::Policy>((data[0] >> 1) % hil::kPolicyNames.size());
  options.flight_software.delay = (data[0] >> 4) % 3;
  options.timing.spin = (data[0] & 0x80) != 0 ? 1e-4 : 0;  // s; with warm-up steps
  options.flight_software.pause_limit = 0.1;               // s; the clock jumps there
  FuzzConnection connection({data + 1, size - 1}, static_cast<std::int64_t>(simulation->plan().get_hash()));
  hil::Recorder recorder("", hil::build_log_header(scenario, *simulation, options.pace, kSession, options.last_tick),
                         kRoom);
  hil::LogEnd end = hil::Executive(*simulation, connection, recorder, scenario.name, options).run();
  recorder.close(end);
  fuzz::require(end.tick == simulation->get_tick() && end.tick <= options.last_tick, "an end that is elsewhere");
  fuzz::require(fuzz::is_finite(simulation->state()), "a number that is not finite in the state");
  for (const double value : simulation->channels()) {
    fuzz::require(value >= 0.2 && value <= 1, "a channel outside its range");
  }
  return 0;
}
