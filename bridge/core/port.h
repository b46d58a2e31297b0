// A port: the endpoint of a transport. Four transports make ports: in-process, Cyclone DDS, LCM, plain UDP.
//
// A Port is a datagram service: messages of one kind from one sender arrive in order, messages of different kinds may
// overtake one another, and any may be lost. The protocol above (sequence numbers, StepAck, Hello again until answered)
// copes with that.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hil/session/messages/messages.h"

namespace unlatch::bridge {

using hil::Message;
using hil::MessageKind;

// The simulator publishes Hello, Catalog, State, Event, Health and so on and receives the rest; a participant (flight
// software) the reverse, without Reactions and Source, which are for displays; an observer (logger, watch) receives
// everything and publishes nothing. A simulator receives the Hello of others too, also of one with its session number,
// but not its own.
enum class Role { kSimulator, kParticipant, kObserver };

[[nodiscard]] bool publishes(Role role, MessageKind kind) noexcept;
[[nodiscard]] bool receives(Role role, MessageKind kind) noexcept;

// A connection cannot be opened: what() has the reason and the remedy.
class PortError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PortCounts {
  std::int64_t published = 0;
  std::int64_t publish_failures = 0;  // refused by the middleware, or not this role's to publish
  std::int64_t received = 0;
  std::int64_t malformed = 0;  // wrong length or fingerprint, or numbers out of the schema's ranges
  std::int64_t lost = 0;       // on their way to this port, as far as the transport notices
  std::int64_t unfit = 0;      // others' readers and writers that do not match ours, see UnfitPeers
};

// Readers or writers of other programs that the transport does not connect with ours, since they ask for another
// quality of service (DDS): such a reader receives nothing, and nothing is received from such a writer.
struct UnfitPeers {
  hil::MessageKind kind = hil::MessageKind::kHello;  // of the topic
  bool read = false;                                 // they are readers; else writers
  std::string_view policy;                           // that differs, by its name in the standard; of the latest of them
  std::int64_t count = 0;                            // since the port was opened
};

// A sentence for people.
[[nodiscard]] std::string describe(const UnfitPeers& peers);

// Opened and closed by one thread. In between one thread may publish while another polls.
class Port {
 public:
  virtual ~Port() = default;
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  // False if it was not sent, which is counted. May allocate and take milliseconds: never from the cyclic thread.
  bool publish(const Message& message);

  // The next message, waiting for it at most `wait` (0: not at all). False if none came. Malformed ones are counted and
  // skipped.
  bool poll(Message& message, std::chrono::nanoseconds wait);

  // From any thread.
  [[nodiscard]] PortCounts get_counts() const;
  // From any thread; allocates.
  [[nodiscard]] virtual std::vector<UnfitPeers> list_unfit() const { return {}; }
  [[nodiscard]] std::int64_t get_malformed() const {
    return malformed_.load(std::memory_order_relaxed) + get_unreadable();
  }

 protected:
  // kNothing: the wait is over; kOther: something came that is no message, look again.
  enum class Received { kNothing, kMessage, kMalformed, kOther };

  explicit Port(Role role) : role_(role) {}

  virtual bool send(const Message& message) = 0;
  virtual Received receive(Message& message, std::chrono::nanoseconds wait) = 0;

  // Messages lost on their way to this port, as far as the transport notices.
  [[nodiscard]] virtual std::int64_t get_lost() const { return 0; }
  // Malformed messages that the transport's own library has dropped (DDS: of this process).
  [[nodiscard]] virtual std::int64_t get_unreadable() const noexcept { return 0; }

 private:
  const Role role_;
  std::atomic<std::int64_t> published_{0};
  std::atomic<std::int64_t> publish_failures_{0};
  std::atomic<std::int64_t> received_{0};
  std::atomic<std::int64_t> malformed_{0};
};

// In-process: every port gets a queue of its own in which the newest `capacity` messages are kept. A late joiner gets
// nothing of what was sent before. Ports may outlive their hub. Thread-safe.
class InprocHub {
 public:
  explicit InprocHub(std::size_t capacity = 1024);
  ~InprocHub();
  InprocHub(const InprocHub&) = delete;
  InprocHub& operator=(const InprocHub&) = delete;

  [[nodiscard]] std::unique_ptr<Port> open(Role role);

  struct Shared;  // the list of queues, in inproc_port.cc

 private:
  std::shared_ptr<Shared> shared_;
};

// Cyclone DDS. Loopback alone unless another interface is named. A configuration in the environment variable
// CYCLONEDDS_URI replaces ours altogether, interface included. Throws PortError.
struct DdsOptions {
  int domain = 0;  // 0 to 230
  std::string interface = "lo";
  std::string security =
      {};  // folder with an identity, see SECURITY.md; empty: none, and open to every program on the interface
};
[[nodiscard]] std::unique_ptr<Port> open_dds_port(Role role, const DdsOptions& options = {});

// LCM over UDP multicast; ttl=0 keeps messages on this machine. LCM sends and receives through the interface that the
// machine's route for multicast leads to: if that is not the one expected here, opening is refused. Throws PortError.
struct LcmOptions {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string interface = "lo";
};
[[nodiscard]] std::unique_ptr<Port> open_lcm_port(Role role, const LcmOptions& options = {});

// Plain UDP, without middleware (bridge/UDP.md): the simulator is bound to the address, all others send to it and
// receive from it. It passes what participants send on to observers. Throws PortError.
struct UdpOptions {
  std::string address = "127.0.0.1:7670";  // IPv4 and port
};
[[nodiscard]] std::unique_ptr<Port> open_udp_port(Role role, const UdpOptions& options = {});

// A serial line between the simulator and one other program, with the datagrams of UDP as frames (bridge/UDP.md).
// Throws PortError.
struct UartOptions {
  std::string device;  // "/dev/ttyUSB0"
  int baud = 115200;   // 8 bits, no parity, one stop bit
};
// "/dev/ttyUSB0,115200", or without the rate. Throws PortError.
[[nodiscard]] UartOptions parse_uart(const std::string& text);
[[nodiscard]] std::unique_ptr<Port> open_uart_port(Role role, const UartOptions& options);

// A sentence for people: the interface used, and who else may use it.
[[nodiscard]] std::string describe(const DdsOptions& options);
[[nodiscard]] std::string describe(const LcmOptions& options);
[[nodiscard]] std::string describe(const UdpOptions& options);
[[nodiscard]] std::string describe(const UartOptions& options);

}  // namespace unlatch::bridge
