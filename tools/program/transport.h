// Transport options, common to all tools.
#pragma once

#include <memory>
#include <string>

#include "bridge/core/port.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {

struct TransportOptions {
  std::string name;
  bridge::DdsOptions dds;  // its interface is LCM's as well
  std::string lcm_url = bridge::LcmOptions{}.url;
  bridge::UdpOptions udp;
};

// Adds --transport (required; inproc only where it makes sense), --domain, --interface, --security, --lcm-url, --udp.
void add_transport_options(Command command, TransportOptions& options, bool with_inproc);

// In front of the device and rate of a serial port: uart:/dev/ttyUSB0,115200.
inline constexpr const char* kUart = "uart:";

// dds, lcm, udp or uart:…; says on standard error where messages will go. Throws bridge::PortError.
std::unique_ptr<bridge::Port> open_port(const TransportOptions& options, bridge::Role role);

}  // namespace unlatch::tools
