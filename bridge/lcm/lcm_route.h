// The interface that an LCM address leads to: LCM itself leaves that to the machine's routes.
#pragma once

#include <cstdint>
#include <string>

namespace unlatch::bridge {

struct LcmRoute {
  std::string interface;  // which the route for the address's group leads through; empty: there is no route
  int ttl = 0;            // 0: messages stay on this machine, whatever the interface
  std::string group;      // e.g. 239.255.76.67
  std::uint16_t port = 0;
};

// `url`: udpm://GROUP:PORT?ttl=N, parts of which may be missing.
[[nodiscard]] LcmRoute find_lcm_route(const std::string& url);

}  // namespace unlatch::bridge
