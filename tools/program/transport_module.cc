// Module unlatch-transports: the middleware, Cyclone DDS and LCM, plain UDP and serial ports.
#include <cstdio>
#include <string_view>

#include "tools/program/transport.h"

namespace unlatch::tools {
namespace {

std::unique_ptr<bridge::Port> open(const TransportOptions& options, bridge::Role role) {
  if (options.name == "lcm") {
    if (!options.dds.security.empty()) throw bridge::PortError("LCM has no security: use --transport dds");
    const bridge::LcmOptions lcm{options.lcm_url, options.dds.interface};
    auto port = bridge::open_lcm_port(role, lcm);
    std::fprintf(stderr, "%s\n", describe(lcm).c_str());  // what is true only once it is open
    return port;
  }
  if (options.name == "udp") {
    if (!options.dds.security.empty()) throw bridge::PortError("UDP has no security: use --transport dds");
    if (options.dds.interface != bridge::DdsOptions{}.interface) {
      throw bridge::PortError(
          "UDP uses the interface that its address belongs to: --udp ADDRESS:PORT, without --interface");
    }
    auto port = bridge::open_udp_port(role, options.udp);
    std::fprintf(stderr, "%s\n", describe(options.udp).c_str());
    return port;
  }
  if (options.name.starts_with(kUart)) {
    if (!options.dds.security.empty()) throw bridge::PortError("a serial line has no security: use --transport dds");
    const bridge::UartOptions uart = bridge::parse_uart(options.name.substr(std::string_view(kUart).size()));
    auto port = bridge::open_uart_port(role, uart);
    std::fprintf(stderr, "%s\n", describe(uart).c_str());
    return port;
  }
  if (options.name != "dds")
    throw bridge::PortError("no transport is called '" + options.name + "': dds, lcm, udp or uart:DEVICE,BAUD");
  auto port = bridge::open_dds_port(role, options.dds);
  std::fprintf(stderr, "%s\n", describe(options.dds).c_str());
  return port;
}

}  // namespace
}  // namespace unlatch::tools

extern "C" unlatch::bridge::Port* unlatch_open_port(const unlatch::tools::TransportOptions& options,
                                                    unlatch::bridge::Role role) {
  return unlatch::tools::open(options, role).release();
}
