// unlatch-fsw: the reference flight software, a program of its own that knows the simulator by its messages alone.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "tools/exit_codes.h"
#include "tools/fsw/participant.h"
#include "tools/interrupt.h"
#include "tools/transport.h"
#include "tools/unlatch/manual.h"
#include "tools/unlatch/verb.h"

int main(int argc, char** argv) {
  using namespace unlatch;
  CLI::App app{
      "Reference flight software: the separation cyclogram of strap-on boosters, over DDS or LCM. It knows the "
      "simulator by its messages alone, and may be started before or after it.",
      "unlatch-fsw"};
  app.footer(
      "Example:\n"
      "  unlatch hil hil/scenarios/boosters/scenario.yaml --transport dds --pace realtime &\n"
      "  unlatch-fsw --transport dds");
  tools::TransportOptions transport;
  std::string name = "fsw";
  double patience_s = 60;
  tools::add_transport_options(app, transport, false);
  app.add_option("--name", name, "name under which the scenario requires it")->type_name("NAME")->capture_default_str();
  app.add_option("--patience", patience_s, "gives up when it has heard no simulator for so long, s")
      ->type_name("SECONDS")
      ->check(tools::check_seconds)
      ->capture_default_str();
  // For the build.
  app.add_option_function<std::string>("--manual",
                                       [&app](const std::string& path) {
                                         std::ofstream(path) << tools::build_manual(app, nullptr);
                                         throw CLI::Success();
                                       })
      ->trigger_on_parse()
      ->group("");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? tools::kExitDone : tools::kExitUsage;
  }

  const std::atomic<bool>& stop = tools::catch_interrupts();
  try {
    const auto port = tools::open_port(transport, bridge::Role::kParticipant);
    std::fprintf(stderr, "unlatch-fsw: '%s' waits for a simulator on %s\n", name.c_str(), transport.name.c_str());
    fsw::ParticipantClient participant(*port, name);
    const auto outcome = participant.run(patience_s, stop);
    std::fprintf(stderr, "unlatch-fsw: %s\n", outcome.explanation.c_str());
    return outcome.done || stop ? tools::kExitDone : tools::kExitFailed;
  } catch (const bridge::PortError& error) {
    std::fprintf(stderr, "unlatch-fsw: %s\n", error.what());
    return tools::kExitEnvironment;
  }
}
