// The UART transport: a serial line with a program at each end, the simulator and one other. The frames are the
// datagrams of the UDP transport. The simulator sends nothing until the other end has joined, which it does again and
// again, since either side may start first or restart.
#include <array>
#include <charconv>
#include <deque>
#include <mutex>
#include <optional>
#include <random>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "bridge/core/message_ring.h"
#include "bridge/core/port.h"
#include "bridge/uart/frame_reader.h"
#include "bridge/uart/serial_line.h"

namespace unlatch::bridge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kRingBytes = std::size_t{1} << 22;
constexpr std::chrono::seconds kForgetAfter(3);  // without a frame of the other end

constexpr std::chrono::seconds kFarewell(1);  // for descriptions, when the port is closed

// A message that describes the session, encoded.
struct Description {
  MessageKind kind;
  std::int64_t part;  // of several of its kind
  std::vector<std::uint8_t> payload;
};

// Empty for all messages but those that describe the session.
std::optional<std::int64_t> find_part(const Message& message) {
  switch (message.kind) {
    case MessageKind::kHello:
      return 0;
    case MessageKind::kCatalog:
      return (std::int64_t{message.catalog.kind} << 32) + message.catalog.index;
    case MessageKind::kSource:
      return message.source.part;
    default:
      return std::nullopt;
  }
}

class UartPort final : public Port {
 public:
  UartPort(Role role, const UartOptions& options)
      : Port(role),
        role_(role),
        run_(std::random_device{}()),
        ring_(kRingBytes),
        reader_([this](const UdpPacket& packet) { accept(packet); }),
        line_(options, {.read = [this](auto bytes) { read(bytes); },
                        .free = [this] { send_description(); },
                        .silent = [this] { reader_.give_up(), note_gaps(); },
                        .idle = [this] { look_after(); }}) {
    look_after();
  }
  ~UartPort() override {
    for (const auto end = Clock::now() + kFarewell; count_descriptions() > 0 && Clock::now() < end;)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  bool send(const Message& message) override {
    const std::size_t length = hil::encode(message, std::span(frame_).subspan(kUdpHeaderBytes));
    if (length == 0) return false;
    const std::scoped_lock lock(mutex_);
    if (role_ == Role::kSimulator && (!is_joined_ || !receives(other_, message.kind))) return true;
    const std::span<const std::uint8_t> payload(frame_.data() + kUdpHeaderBytes, length);
    if (const auto part = find_part(message)) return describe({message.kind, *part, {payload.begin(), payload.end()}});
    const bool waits = line_.count_waiting() > 0;
    // In lockstep a State is repeated until it is answered: on a slow line it is still on its way.
    if (waits && message.kind == MessageKind::kState && std::ranges::equal(payload, latest_state_)) return true;
    const std::size_t bytes = seal_udp_message({.run = run_, .sequence = sent_++}, message.kind, frame_, length);
    if (!line_.write(std::span(frame_).first(bytes))) return false;
    if (message.kind == MessageKind::kState) latest_state_.assign(payload.begin(), payload.end());
    return true;
  }

  // Descriptions come again and again, faster than a slow line carries them: of each the latest waits, until nothing
  // else does, so that a State stays behind one of them at most.
  bool describe(Description&& description) {
    const auto same = std::ranges::find_if(descriptions_, [&](const Description& other) {
      return other.kind == description.kind && other.part == description.part;
    });
    if (same != descriptions_.end())
      *same = std::move(description);
    else
      descriptions_.push_back(std::move(description));
    line_.wake();
    return true;
  }
  std::size_t count_descriptions() {
    const std::scoped_lock lock(mutex_);
    return is_joined_ ? descriptions_.size() : 0;
  }

  Received receive(Message& message, std::chrono::nanoseconds wait) override {
    bool readable = false;
    if (!ring_.pop(message, readable, wait)) return Received::kNothing;
    return readable ? Received::kMessage : Received::kMalformed;
  }
  [[nodiscard]] std::int64_t get_lost() const override {
    return ring_.get_lost() + lost_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::int64_t get_unreadable() const noexcept override {
    return malformed_.load(std::memory_order_relaxed) + gaps_.load(std::memory_order_relaxed);
  }

  // --- By the line's thread
  void read(std::span<const std::uint8_t> bytes) {
    reader_.push(bytes);
    note_gaps();
  }
  void send_description() {
    const std::scoped_lock lock(mutex_);
    if (descriptions_.empty()) return;
    if (is_joined_) {
      const Description& next = descriptions_.front();
      std::array<std::uint8_t, kMaxUdpBytes> frame{};
      std::ranges::copy(next.payload, frame.begin() + kUdpHeaderBytes);
      const std::size_t bytes =
          seal_udp_message({.run = run_, .sequence = sent_++}, next.kind, frame, next.payload.size());
      (void)line_.write(std::span(frame).first(bytes));
    }
    descriptions_.pop_front();
  }
  void note_gaps() { gaps_.store(reader_.get_gaps(), std::memory_order_relaxed); }

  void accept(const UdpPacket& packet) {
    const std::int64_t lost = received_.get_lost();
    if (!received_.accept(packet.header)) return;
    if (received_.get_lost() > lost) lost_.fetch_add(received_.get_lost() - lost, std::memory_order_relaxed);
    heard_ = Clock::now();
    if (!packet.kind) {
      if (role_ != Role::kSimulator) return add_malformed();
      const std::scoped_lock lock(mutex_);
      is_joined_ = true;
      other_ = packet.role;
      return;
    }
    if (!is_expected(*packet.kind)) return add_malformed();
    ring_.push(*packet.kind, packet.payload);
  }

  // Of what the other end may send. Two simulators on one line are a mistake that both report.
  bool is_expected(MessageKind kind) {
    if (role_ != Role::kSimulator) return receives(role_, kind);
    const std::scoped_lock lock(mutex_);
    return is_joined_ && publishes(other_, kind);
  }

  // Joins again; forgets an end that is silent.
  void look_after() {
    const std::scoped_lock lock(mutex_);
    if (role_ == Role::kSimulator) {
      if (is_joined_ && Clock::now() - heard_ > kForgetAfter) is_joined_ = false;
      return;
    }
    if (line_.count_waiting() > 0) return;  // of which each says as much
    std::array<std::uint8_t, kUdpHeaderBytes + 4> frame{};
    (void)line_.write(std::span(frame).first(build_udp_join({.run = run_, .sequence = sent_++}, role_, frame)));
  }
  void add_malformed() { malformed_.fetch_add(1, std::memory_order_relaxed); }

  const Role role_;
  const std::uint32_t run_;
  MessageRing ring_;
  std::array<std::uint8_t, kMaxUdpBytes> frame_{};  // of the thread that publishes
  std::vector<std::uint8_t> latest_state_;          // likewise
  std::mutex mutex_;
  std::uint32_t sent_ = 0;
  std::deque<Description> descriptions_;
  bool is_joined_ = false;
  Role other_ = Role::kObserver;
  std::atomic<std::int64_t> malformed_{0}, lost_{0}, gaps_{0};
  // of the line's thread
  UdpSequence received_;
  Clock::time_point heard_;
  FrameReader reader_;
  SerialLine line_;  // the last: it uses all others
};

}  // namespace

UartOptions parse_uart(const std::string& text) {
  UartOptions options;
  const std::size_t comma = text.rfind(',');
  options.device = text.substr(0, comma);
  if (comma != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + comma + 1, end, options.baud);
    if (error != std::errc{} || stop != end) options.baud = 0;
  }
  if (options.device.empty() || options.baud <= 0) {
    throw PortError("UART: '" + text + "' is no serial port and rate; write it like uart:/dev/ttyUSB0,115200");
  }
  return options;
}

std::string describe(const UartOptions& options) {
  return "UART, " + options.device + " at " + std::to_string(options.baud) +
         " baud: whoever is at its other end may listen and command";
}

std::unique_ptr<Port> open_uart_port(Role role, const UartOptions& options) {
  return std::make_unique<UartPort>(role, options);
}

}  // namespace unlatch::bridge
