// The UDP transport, for benches without middleware. The simulator is the hub: it is bound to one address, and sends to
// those that have joined. Participants and observers send to that address alone, and join again and again, since either
// side may start first or restart. The hub passes what participants send on to observers.
#include <arpa/inet.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <mutex>
#include <random>
#include <string_view>

#include "bridge/core/datagram_receiver.h"
#include "bridge/core/message_ring.h"
#include "bridge/core/port.h"
#include "bridge/udp/udp_packet.h"

namespace unlatch::bridge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kTransport = "UDP";
constexpr std::size_t kRingBytes = std::size_t{1} << 22;
constexpr std::size_t kMaxPeers = 64;
constexpr std::chrono::milliseconds kJoinInterval(100);
constexpr std::chrono::seconds kForgetAfter(3);  // without a datagram of the peer

sockaddr_in parse_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  std::uint16_t port = 0;
  if (colon != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, port);
    if (error != std::errc{} || stop != end) port = 0;
  }
  if (port == 0 || inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    throw PortError("UDP: '" + text + "' is no address of IPv4 and a port; write it like " + UdpOptions{}.address);
  }
  address.sin_port = htons(port);
  return address;
}

bool is_loopback(const sockaddr_in& address) { return ntohl(address.sin_addr.s_addr) >> 24U == 127; }

// Both roles: a socket, what has come, and the counts of it.
class UdpPort : public Port {
 protected:
  UdpPort(Role role, const std::string& address)
      : Port(role),
        role_(role),
        socket_(open_datagram_socket(kTransport)),
        address_(parse_address(address)),
        run_(std::random_device{}()),
        ring_(kRingBytes) {}

  Received receive(Message& message, std::chrono::nanoseconds wait) override {
    bool readable = false;
    if (!ring_.pop(message, readable, wait)) return Received::kNothing;
    return readable ? Received::kMessage : Received::kMalformed;
  }
  [[nodiscard]] std::int64_t get_lost() const override {
    return ring_.get_lost() + lost_.load(std::memory_order_relaxed);
  }
  [[nodiscard]] std::int64_t get_unreadable() const noexcept override {
    return malformed_.load(std::memory_order_relaxed);
  }

  // The message's bytes behind a free header; 0: none.
  std::size_t encode(const Message& message) {
    return hil::encode(message, std::span(datagram_).subspan(kUdpHeaderBytes));
  }
  void add_malformed() { malformed_.fetch_add(1, std::memory_order_relaxed); }
  void add_lost(std::int64_t count) {
    if (count > 0) lost_.fetch_add(count, std::memory_order_relaxed);
  }

  const Role role_;
  const Descriptor socket_;
  const sockaddr_in address_;  // the simulator's
  const std::uint32_t run_;
  MessageRing ring_;
  std::array<std::uint8_t, kMaxUdpBytes> datagram_{};  // of the thread that publishes

 private:
  std::atomic<std::int64_t> malformed_{0}, lost_{0};
};

// --- The simulator's
// --------------------------------------------------------------------------------------------------

class UdpHub final : public UdpPort {
 public:
  explicit UdpHub(const std::string& address)
      : UdpPort(Role::kSimulator, address),
        receiver_(
            bind_socket(address), [this](const sockaddr_in& from, auto datagram) { accept(from, datagram); },
            [this] { forget_silent(); }, std::chrono::milliseconds(kForgetAfter) / 4) {}

 private:
  struct Peer {
    sockaddr_in address{};  // port 0: a free place
    Role role = Role::kObserver;
    std::uint32_t sent = 0;
    UdpSequence received;
    Clock::time_point heard;
  };

  int bind_socket(const std::string& address) {
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_) == 0) return socket_.get();
    const int error = errno;
    throw PortError("UDP: the simulator cannot have the address " + address + ": " + std::strerror(error) +
                    (error == EADDRINUSE ? "; another simulator, or another program, has it: give this one and its "
                                           "flight software another port (--udp)"
                                         : "; it must be one of this machine's (`ip address`)"));
  }

  bool send(const Message& message) override {
    const std::size_t length = encode(message);
    if (length == 0) return false;
    bool sent = true;
    const std::scoped_lock lock(mutex_);
    for (Peer& peer : peers_) {
      if (peer.address.sin_port != 0 && receives(peer.role, message.kind)) {
        sent = send_to(peer, message.kind, datagram_, length) && sent;
      }
    }
    return sent;
  }

  // `datagram`: the message's bytes behind a free header.
  bool send_to(Peer& peer, MessageKind kind, std::span<std::uint8_t> datagram, std::size_t message_bytes) {
    const std::size_t length = seal_udp_message({.run = run_, .sequence = peer.sent++}, kind, datagram, message_bytes);
    return sendto(socket_.get(), datagram.data(), length, MSG_DONTWAIT,
                  reinterpret_cast<const sockaddr*>(&peer.address),
                  sizeof peer.address) == static_cast<ssize_t>(length);
  }

  void accept(const sockaddr_in& from, std::span<const std::uint8_t> datagram) {
    const std::optional<UdpPacket> packet = read_udp_packet(datagram);
    if (!packet) return add_malformed();
    const std::scoped_lock lock(mutex_);
    Peer* const peer = packet->kind ? find(from) : find_or_add(from);
    if (peer == nullptr) return add_malformed();  // has not joined, or there is no place
    const std::int64_t lost = peer->received.get_lost();
    if (!peer->received.accept(packet->header)) return;
    add_lost(peer->received.get_lost() - lost);
    peer->heard = Clock::now();
    if (!packet->kind) {
      peer->role = packet->role;
      return;
    }
    if (!publishes(peer->role, *packet->kind)) return add_malformed();
    ring_.push(*packet->kind, packet->payload);
    if (packet->payload.size() > hil::kMaxWireBytes) return;
    std::copy(packet->payload.begin(), packet->payload.end(), relayed_.begin() + kUdpHeaderBytes);
    for (Peer& other : peers_) {
      if (other.address.sin_port != 0 && other.role == Role::kObserver) {
        (void)send_to(other, *packet->kind, relayed_, packet->payload.size());
      }
    }
  }

  Peer* find(const sockaddr_in& address) {
    for (Peer& peer : peers_) {
      if (peer.address.sin_port == address.sin_port && peer.address.sin_addr.s_addr == address.sin_addr.s_addr) {
        return &peer;
      }
    }
    return nullptr;
  }

  Peer* find_or_add(const sockaddr_in& address) {
    if (address.sin_port == 0) return nullptr;
    if (Peer* const known = find(address)) return known;
    for (Peer& peer : peers_) {
      if (peer.address.sin_port != 0) continue;
      peer = Peer{.address = address, .received = {}, .heard = Clock::now()};
      return &peer;
    }
    return nullptr;
  }

  void forget_silent() {
    const Clock::time_point now = Clock::now();
    const std::scoped_lock lock(mutex_);
    for (Peer& peer : peers_) {
      if (peer.address.sin_port != 0 && now - peer.heard > kForgetAfter) peer = {};
    }
  }

  std::mutex mutex_;
  std::array<Peer, kMaxPeers> peers_;
  std::array<std::uint8_t, kMaxUdpBytes> relayed_{};  // of the receiver's thread
  DatagramReceiver receiver_;                         // the last: it uses all others
};

// --- Participants' and observers'
// -------------------------------------------------------------------------------------

class UdpClient final : public UdpPort {
 public:
  UdpClient(Role role, const std::string& address)
      : UdpPort(role, address),
        receiver_(
            connect_socket(), [this](const sockaddr_in&, auto datagram) { accept(datagram); }, [this] { join(); },
            kJoinInterval) {
    join();
  }

 private:
  // Connected: the system keeps away what does not come from the simulator's address.
  int connect_socket() {
    if (connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_) != 0) {
      throw_port_error(kTransport, "connecting");
    }
    return socket_.get();
  }

  bool send(const Message& message) override {
    const std::size_t length = encode(message);
    if (length == 0) return false;
    const std::scoped_lock lock(mutex_);
    const std::size_t bytes = seal_udp_message({.run = run_, .sequence = sent_++}, message.kind, datagram_, length);
    return ::send(socket_.get(), datagram_.data(), bytes, MSG_DONTWAIT) == static_cast<ssize_t>(bytes);
  }

  // Fails while there is no simulator, which is no error.
  void join() {
    std::array<std::uint8_t, kUdpHeaderBytes + 4> datagram{};
    const std::scoped_lock lock(mutex_);
    const std::size_t bytes = build_udp_join({.run = run_, .sequence = sent_++}, role_, datagram);
    (void)!::send(socket_.get(), datagram.data(), bytes, MSG_DONTWAIT);
  }

  void accept(std::span<const std::uint8_t> datagram) {
    const std::optional<UdpPacket> packet = read_udp_packet(datagram);
    if (!packet || !packet->kind) return add_malformed();
    const std::int64_t lost = received_.get_lost();
    if (!received_.accept(packet->header)) return;
    add_lost(received_.get_lost() - lost);
    if (receives(role_, *packet->kind)) ring_.push(*packet->kind, packet->payload);
  }

  std::mutex mutex_;
  std::uint32_t sent_ = 0;
  UdpSequence received_;       // of the receiver's thread
  DatagramReceiver receiver_;  // the last: it uses all others
};

}  // namespace

std::string describe(const UdpOptions& options) {
  const sockaddr_in address = parse_address(options.address);
  return "UDP, the simulator at " + options.address + ": " +
         (is_loopback(address) ? "this machine only; every process on it may listen and command"
                               : "everyone who reaches that address may listen and command; UDP has no access control");
}

std::unique_ptr<Port> open_udp_port(Role role, const UdpOptions& options) {
  if (role == Role::kSimulator) return std::make_unique<UdpHub>(options.address);
  return std::make_unique<UdpClient>(role, options.address);
}

}  // namespace unlatch::bridge
