#include "tools/program/transport.h"

#include <vector>

#include "hil/scenario/base/module.h"

namespace unlatch::tools {

void add_transport_options(Command command, TransportOptions& options, bool with_inproc) {
  std::vector<std::string> names{"dds", "lcm", "udp", kUart};
  if (with_inproc) names.push_back("inproc");
  command.add_option("--transport", options.name, "message transport; uart:DEVICE,BAUD: a serial port")
      .required()
      .one_of(names);
  command.add_option("--domain", options.dds.domain, "DDS domain, 0 to 230")
      .type_name("NUMBER")
      .within(0, 230)
      .default_shown();
  command.add_option("--interface", options.dds.interface, "network interface; lo: this machine only")
      .type_name("NAME")
      .default_shown();
  command
      .add_option("--security", options.dds.security,
                  "DDS: folder with this program's identity (bridge/SECURITY.md); excludes programs without one")
      .type_name("FOLDER");
  command.add_option("--lcm-url", options.lcm_url, "LCM network").type_name("URL").default_shown();
  command
      .add_option("--udp", options.udp.address,
                  "UDP: the simulator's address, of this machine unless the simulator runs on another (bridge/UDP.md)")
      .type_name("ADDRESS:PORT")
      .default_shown();
}

std::unique_ptr<bridge::Port> open_port(const TransportOptions& options, bridge::Role role) try {
  using Open = bridge::Port*(const TransportOptions&, bridge::Role);
  return std::unique_ptr<bridge::Port>(
      hil::find_function<Open>("unlatch-transports", "unlatch_open_port")(options, role));
} catch (const hil::ModuleError& error) {
  throw bridge::PortError(error.what());
}

}  // namespace unlatch::tools
