// unlatch-fsw: the reference flight software, a program of its own that knows the simulator by its messages alone.
#include <cstdio>
#include <fstream>

#include "tools/fsw/participant.h"
#include "tools/fsw/separation_sequence.h"
#include "tools/program/command_line.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/program/manual.h"
#include "tools/program/transport.h"

int main(int argc, char** argv) {
  using namespace unlatch;
  tools::CommandLine command_line(
      "Reference flight software: the separation cyclogram of strap-on boosters and the attitude loop of their core, "
      "over DDS, LCM, UDP or a serial line (UART). It knows only the messages of the simulator, and may be started "
      "before or after it.",
      "unlatch-fsw",
      "Example:\n"
      "  unlatch hil hil/scenarios/boosters/scenario.yaml --transport dds --pace realtime &\n"
      "  unlatch-fsw --transport dds");
  tools::Command command = command_line.get_command();
  tools::TransportOptions transport;
  std::string name = "fsw";
  double patience_s = 60;
  std::int64_t session = 0;
  tools::add_transport_options(command, transport, false);
  command.add_option("--name", name, "its name in the scenario").type_name("NAME").default_shown();
  command.add_option("--session", session, "number of the session to take part in; 0: the first one heard")
      .type_name("NUMBER")
      .not_negative();
  command.add_option("--patience", patience_s, "longest wait for a simulator, s")
      .type_name("SECONDS")
      .seconds()
      .default_shown();
  command.add_hidden_action("--manual", [command](const std::string& path) {  // for the build
    std::ofstream(path) << tools::build_manual(command, nullptr);
  });
  int exit_code = tools::kExitDone;
  if (!command_line.parse(argc, argv, exit_code)) return exit_code;

  tools::never_wait_for_stderr();
  const std::atomic<bool>& stop = tools::catch_interrupts();
  try {
    const auto port = tools::open_port(transport, bridge::Role::kParticipant);
    std::fprintf(stderr, "unlatch-fsw: '%s' waits for a simulator on %s\n", name.c_str(), transport.name.c_str());
    fsw::SeparationSequence sequence;
    fsw::ParticipantClient participant(*port, sequence, name, session);
    const auto outcome = participant.run(patience_s, stop);
    std::fprintf(stderr, "unlatch-fsw: %s\n", outcome.explanation.c_str());
    return outcome.done || stop ? tools::kExitDone : tools::kExitFailed;
  } catch (const bridge::PortError& error) {
    std::fprintf(stderr, "unlatch-fsw: %s\n", error.what());
    return tools::kExitEnvironment;
  }
}
