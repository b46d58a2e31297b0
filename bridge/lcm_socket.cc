#include "bridge/lcm_socket.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace unlatch::bridge {
namespace {

constexpr std::size_t kRingBytes = std::size_t{1} << 22;
constexpr int kSocketBytes = 1 << 23;          // as far as the machine allows it (net.core.rmem_max)
constexpr std::size_t kDatagramBytes = 65536;  // more than any has
constexpr int kDatagramsAtOnce = 256;          // between two looks at the request to stop

template <class T>
bool set_option(int socket, int level, int name, const T& value) {
  return setsockopt(socket, level, name, &value, sizeof value) == 0;
}

[[noreturn]] void fail(const char* what) {
  throw PortError(std::string("LCM: ") + what + " failed: " + std::strerror(errno));
}

}  // namespace

LcmSocket::Descriptor::~Descriptor() {
  if (file_ >= 0) close(file_);
}

LcmSocket::LcmSocket(Role role, const LcmRoute& route, const std::string& interface)
    : role_(role),
      socket_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
      stop_(eventfd(0, EFD_CLOEXEC)),
      ring_(kRingBytes),
      datagram_(kDatagramBytes) {
  if (socket_.get() < 0 || stop_.get() < 0) fail("opening a socket");
  join_group(route, interface);
  thread_ = std::jthread([this] { run(); });
}

LcmSocket::~LcmSocket() {
  const std::uint64_t one = 1;
  (void)!write(stop_.get(), &one, sizeof one);
}

// Bound to the group: a datagram to this machine's own address is none of ours, nor is one for a group that another
// program has joined elsewhere.
void LcmSocket::join_group(const LcmRoute& route, const std::string& interface) const {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(route.port);
  if (inet_pton(AF_INET, route.group.c_str(), &address.sin_addr) != 1) {
    throw PortError("LCM: '" + route.group + "' is no address of a multicast group");
  }
  ip_mreqn group{};
  group.imr_multiaddr = address.sin_addr;
  group.imr_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  if (!set_option(socket_.get(), SOL_SOCKET, SO_REUSEADDR, 1)) fail("sharing the port");
  if (!set_option(socket_.get(), SOL_SOCKET, SO_RCVBUFFORCE, kSocketBytes)) {
    (void)set_option(socket_.get(), SOL_SOCKET, SO_RCVBUF, kSocketBytes);
  }
  (void)set_option(socket_.get(), SOL_SOCKET, SO_RXQ_OVFL, 1);
  if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fail("binding the port");
  if (!set_option(socket_.get(), IPPROTO_IP, IP_MULTICAST_ALL, 0)) fail("refusing the groups of others");
  if (!set_option(socket_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, group)) fail("joining the group");
}

void LcmSocket::run() {
  while (true) {
    std::array<pollfd, 2> waiting{{{socket_.get(), POLLIN, 0}, {stop_.get(), POLLIN, 0}}};
    if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    if (waiting[1].revents != 0) return;
    if (waiting[0].revents == 0) continue;
    for (int i = 0; i < kDatagramsAtOnce; ++i) {
      errno = 0;
      receive();
      if (errno != 0) break;
    }
  }
}

// One datagram; errno is set when there was none.
void LcmSocket::receive() {
  sockaddr_in from{};
  iovec bytes{datagram_.data(), datagram_.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint32_t))> control{};
  msghdr header{};
  header.msg_name = &from;
  header.msg_namelen = sizeof from;
  header.msg_iov = &bytes;
  header.msg_iovlen = 1;
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  const ssize_t length = recvmsg(socket_.get(), &header, 0);
  if (length < 0) return;
  for (cmsghdr* one = CMSG_FIRSTHDR(&header); one != nullptr; one = CMSG_NXTHDR(&header, one)) {
    if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t overflowed = 0;
    std::memcpy(&overflowed, CMSG_DATA(one), sizeof overflowed);
    overflowed_.store(overflowed, std::memory_order_relaxed);
  }
  const std::uint64_t sender = std::uint64_t{from.sin_addr.s_addr} << 16U | from.sin_port;
  LcmPackets::Packet packet;
  const auto result = packets_.accept(sender, std::span(datagram_).first(static_cast<std::size_t>(length)), packet);
  if (result == LcmPackets::Result::kMessage) {
    if (receives(role_, packet.kind)) ring_.push(packet.kind, packet.data);
  } else if (result == LcmPackets::Result::kMalformed) {
    malformed_.fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace unlatch::bridge
