#include "tools/transport.h"

#include <cstdio>
#include <vector>

namespace unlatch::tools {

void add_transport_options(Command command, TransportOptions& options, bool with_inproc) {
  std::vector<std::string> names{"dds", "lcm"};
  if (with_inproc) names.push_back("inproc");
  command.add_option("--transport", options.name, "what carries the messages").required().one_of(names);
  command.add_option("--domain", options.dds.domain, "DDS domain, 0 to 230")
      .type_name("NUMBER")
      .within(0, 230)
      .default_shown();
  command
      .add_option("--interface", options.dds.interface, "network interface; lo: nobody outside this machine takes part")
      .type_name("NAME")
      .default_shown();
  command
      .add_option("--security", options.dds.security,
                  "DDS: folder with this program's identity (bridge/SECURITY.md); nobody without one takes part")
      .type_name("FOLDER");
  command.add_option("--lcm-url", options.lcm_url, "LCM network").type_name("URL").default_shown();
}

std::unique_ptr<bridge::Port> open_port(const TransportOptions& options, bridge::Role role) {
  if (options.name == "lcm") {
    if (!options.dds.security.empty()) throw bridge::PortError("LCM has no security: use --transport dds");
    const bridge::LcmOptions lcm{options.lcm_url, options.dds.interface};
    std::fprintf(stderr, "%s\n", describe(lcm).c_str());
    return bridge::open_lcm_port(role, lcm);
  }
  std::fprintf(stderr, "%s\n", describe(options.dds).c_str());
  return bridge::open_dds_port(role, options.dds);
}

}  // namespace unlatch::tools
