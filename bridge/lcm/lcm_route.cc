#include "bridge/lcm/lcm_route.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace unlatch::bridge {
namespace {

constexpr std::size_t kScheme = 7;  // udpm://
constexpr const char* kDefaultGroup = "239.255.76.67";
constexpr std::uint16_t kDefaultPort = 7667;

std::string get_interface(const sockaddr_in& address) {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return {};
  std::string name;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in its{};
    std::memcpy(&its, one->ifa_addr, sizeof its);
    if (its.sin_addr.s_addr == address.sin_addr.s_addr) name = one->ifa_name;
  }
  freeifaddrs(all);
  return name;
}

// The kernel chooses the source address, and with it the interface, when a datagram socket is connected: nothing is
// sent.
std::string find_interface(const std::string& group) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kDefaultPort);  // a route does not depend on it
  if (inet_pton(AF_INET, group.c_str(), &to.sin_addr) != 1) return {};
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in from{};
  socklen_t length = sizeof from;
  const bool found = socket >= 0 && connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
                     getsockname(socket, reinterpret_cast<sockaddr*>(&from), &length) == 0;
  if (socket >= 0) close(socket);
  return found ? get_interface(from) : std::string{};
}

}  // namespace

LcmRoute find_lcm_route(const std::string& url) {
  const std::string network = url.substr(kScheme, url.find('?', kScheme) - kScheme);
  const std::size_t colon = network.find(':');
  std::string group = network.substr(0, colon);
  if (group.empty()) group = kDefaultGroup;
  const int port = colon == std::string::npos ? kDefaultPort : std::atoi(network.c_str() + colon + 1);
  const std::size_t ttl = url.find("ttl=");
  return {find_interface(group), ttl == std::string::npos ? 0 : std::atoi(url.c_str() + ttl + 4), group,
          static_cast<std::uint16_t>(port)};
}

}  // namespace unlatch::bridge
