#include "tools/transport.h"

#include <vector>

namespace unlatch::tools {

void add_transport_options(CLI::App& command, TransportOptions& options, bool with_inproc) {
  std::vector<std::string> names{"dds", "lcm"};
  if (with_inproc) names.push_back("inproc");
  command.add_option("--transport", options.name, "what carries the messages")->required()->check(CLI::IsMember(names));
  command.add_option("--domain", options.dds.domain, "DDS domain")->check(CLI::Range(0, 230))->capture_default_str();
  command.add_option("--interface", options.dds.interface, "network interface for DDS")->capture_default_str();
  command.add_option("--lcm-url", options.lcm.url, "LCM network")->capture_default_str();
}

std::unique_ptr<bridge::Port> open_port(const TransportOptions& options, bridge::Role role) {
  if (options.name == "lcm") return bridge::open_lcm_port(role, options.lcm);
  return bridge::open_dds_port(role, options.dds);
}

}  // namespace unlatch::tools
