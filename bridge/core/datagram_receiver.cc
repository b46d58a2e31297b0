#include "bridge/core/datagram_receiver.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "bridge/core/port.h"

namespace unlatch::bridge {
namespace {

constexpr int kSocketBytes = 1 << 23;          // as far as the machine allows it (net.core.rmem_max)
constexpr std::size_t kDatagramBytes = 65536;  // more than any has
constexpr int kDatagramsAtOnce = 256;          // between two looks at the request to stop

}  // namespace

Descriptor::~Descriptor() {
  if (file_ >= 0) close(file_);
}

void throw_port_error(const std::string& transport, const std::string& what) {
  throw PortError(transport + ": " + what + " failed: " + std::strerror(errno));
}

int open_datagram_socket(const std::string& transport) {
  const int file = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (file < 0) throw_port_error(transport, "opening a socket");
  const int bytes = kSocketBytes, on = 1;
  if (setsockopt(file, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) {
    (void)setsockopt(file, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
  (void)setsockopt(file, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
  return file;
}

DatagramReceiver::DatagramReceiver(int socket, Accept accept, Idle idle, std::chrono::milliseconds period)
    : socket_(socket),
      accept_(std::move(accept)),
      idle_(std::move(idle)),
      period_(period),
      stop_(eventfd(0, EFD_CLOEXEC)),
      datagram_(kDatagramBytes) {
  if (stop_.get() < 0) throw_port_error("a receiver of datagrams", "opening an eventfd");
  thread_ = std::jthread([this] { run(); });
}

DatagramReceiver::~DatagramReceiver() {
  const std::uint64_t one = 1;
  (void)!write(stop_.get(), &one, sizeof one);
}

void DatagramReceiver::run() {
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_idle = Clock::now() + period_;
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next_idle - Clock::now());
    std::array<pollfd, 2> waiting{{{socket_, POLLIN, 0}, {stop_.get(), POLLIN, 0}}};
    if (poll(waiting.data(), waiting.size(), static_cast<int>(std::max<std::int64_t>(left.count(), 0))) < 0 &&
        errno != EINTR) {
      return;
    }
    if (waiting[1].revents != 0) return;
    for (int i = 0; waiting[0].revents != 0 && i < kDatagramsAtOnce; ++i) {
      if (!receive()) break;
    }
    if (Clock::now() >= next_idle) {
      if (idle_) idle_();
      next_idle = Clock::now() + period_;
    }
  }
}

// One datagram; false when there is none.
bool DatagramReceiver::receive() {
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
  const ssize_t length = recvmsg(socket_, &header, 0);
  if (length < 0) return false;
  for (cmsghdr* one = CMSG_FIRSTHDR(&header); one != nullptr; one = CMSG_NXTHDR(&header, one)) {
    if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t overflowed = 0;
    std::memcpy(&overflowed, CMSG_DATA(one), sizeof overflowed);
    overflowed_.store(overflowed, std::memory_order_relaxed);
  }
  accept_(from, std::span(datagram_).first(static_cast<std::size_t>(length)));
  return true;
}

}  // namespace unlatch::bridge
