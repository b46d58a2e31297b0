#include "bridge/lcm/lcm_route.h"

#include <arpa/inet.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

namespace unlatch::bridge {
namespace {

constexpr std::size_t kScheme = 7;  // udpm://
constexpr const char* kDefaultGroup = "239.255.76.67";
constexpr std::uint16_t kDefaultPort = 7667;

struct RouteRequest {
  nlmsghdr head{};
  rtmsg route{};
  rtattr destination_head{};
  in_addr destination{};
};

// The index of the interface in the kernel's answer; 0: there is none.
int find_index(const char* answer, std::size_t length) {
  nlmsghdr head{};
  if (length < NLMSG_LENGTH(sizeof(rtmsg))) return 0;
  std::memcpy(&head, answer, sizeof head);
  if (head.nlmsg_type != RTM_NEWROUTE) return 0;
  std::size_t at = NLMSG_LENGTH(sizeof(rtmsg));
  for (rtattr part{}; at + sizeof part <= length; at += RTA_ALIGN(part.rta_len)) {
    std::memcpy(&part, answer + at, sizeof part);
    if (part.rta_len < sizeof part || at + part.rta_len > length) return 0;
    if (part.rta_type != RTA_OIF || part.rta_len != RTA_LENGTH(sizeof(int))) continue;
    int index = 0;
    std::memcpy(&index, answer + at + RTA_LENGTH(0), sizeof index);
    return index;
  }
  return 0;
}

// Asks the kernel, as `ip route get` does. The address that it would send from says nothing: through the loopback
// interface a machine with a network sends from the network's address.
std::string find_interface(const std::string& group) {
  RouteRequest request;
  if (inet_pton(AF_INET, group.c_str(), &request.destination) != 1) return {};
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = RTM_GETROUTE;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.route.rtm_family = AF_INET;
  request.route.rtm_dst_len = 32;
  request.destination_head.rta_type = RTA_DST;
  request.destination_head.rta_len = RTA_LENGTH(sizeof request.destination);
  const int socket = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
  if (socket < 0) return {};
  alignas(nlmsghdr) std::array<char, 8192> answer{};
  const bool asked = send(socket, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request);
  const ssize_t length = asked ? recv(socket, answer.data(), answer.size(), 0) : 0;
  close(socket);
  std::array<char, IF_NAMESIZE> name{};
  const int index = length > 0 ? find_index(answer.data(), static_cast<std::size_t>(length)) : 0;
  return index > 0 && if_indextoname(static_cast<unsigned>(index), name.data()) != nullptr ? name.data() : "";
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
