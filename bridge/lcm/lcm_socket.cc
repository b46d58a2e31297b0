#include "bridge/lcm/lcm_socket.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/socket.h>

namespace unlatch::bridge {
namespace {

constexpr std::size_t kRingBytes = std::size_t{1} << 22;
constexpr const char* kTransport = "LCM";

template <class T>
bool set_option(int socket, int level, int name, const T& value) {
  return setsockopt(socket, level, name, &value, sizeof value) == 0;
}

// Bound to the group: a datagram to this machine's own address is none of ours, nor is one for a group that another
// program has joined elsewhere.
int join_group(int socket, const LcmRoute& route, const std::string& interface) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(route.port);
  if (inet_pton(AF_INET, route.group.c_str(), &address.sin_addr) != 1) {
    throw PortError("LCM: '" + route.group + "' is no address of a multicast group");
  }
  ip_mreqn group{};
  group.imr_multiaddr = address.sin_addr;
  group.imr_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  if (!set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1)) throw_port_error(kTransport, "sharing the port");
  if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw_port_error(kTransport, "binding the port");
  }
  if (!set_option(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0)) {
    throw_port_error(kTransport, "refusing the groups of others");
  }
  if (!set_option(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, group)) throw_port_error(kTransport, "joining the group");
  return socket;
}

}  // namespace

LcmSocket::LcmSocket(Role role, const LcmRoute& route, const std::string& interface)
    : role_(role),
      socket_(open_datagram_socket(kTransport)),
      ring_(kRingBytes),
      receiver_(join_group(socket_.get(), route, interface),
                [this](const sockaddr_in& from, std::span<const std::uint8_t> datagram) { accept(from, datagram); }) {}

void LcmSocket::accept(const sockaddr_in& from, std::span<const std::uint8_t> datagram) {
  const std::uint64_t sender = std::uint64_t{from.sin_addr.s_addr} << 16U | from.sin_port;
  LcmPackets::Packet packet;
  const auto result = packets_.accept(sender, datagram, packet);
  if (result == LcmPackets::Result::kMessage) {
    if (receives(role_, packet.kind) && !is_own(sender, packet)) ring_.push(packet.kind, packet.data);
  } else if (result == LcmPackets::Result::kMalformed) {
    malformed_.fetch_add(1, std::memory_order_relaxed);
  }
}

// liblcm does not give the address that it sends from: it is that of the first Hello of our session after ours was
// sent. Of two simulators with one session number each so hears another than the first, whichever that is.
bool LcmSocket::is_own(std::uint64_t sender, const LcmPackets::Packet& packet) {
  if (role_ != Role::kSimulator || packet.kind != hil::MessageKind::kHello) return false;
  if (own_sender_) return sender == *own_sender_;
  const std::int64_t session = own_session_.load(std::memory_order_relaxed);
  if (session == kNoSession || !hil::decode(packet.kind, packet.data, hello_)) return false;
  if (hello_.hello.session == session) own_sender_ = sender;
  return own_sender_.has_value();
}

}  // namespace unlatch::bridge
