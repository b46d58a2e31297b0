// unlatch-mpi: campaigns on the ranks of an MPI job.
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "tools/mpi/exchange.h"
#include "tools/mpi/ranks.h"
#include "tools/program/exit_codes.h"
#include "tools/program/interrupt.h"
#include "tools/program/manual.h"
#include "tools/unlatch/program.h"

namespace unlatch::tools {
namespace {

CampaignHost build_host(Ranks& ranks) {
  CampaignHost host;
  host.catch_signals = catch_interrupts_patiently;  // mpirun ends what hangs
  if (ranks.get_rank() == 0) {
    host.run = [&ranks](const CampaignTask& task, hil::ResultFile& results, const std::function<void()>& finished) {
      ranks.begin();
      lead_campaign(ranks.get_communicator(), task, results, finished);
      ranks.end();
    };
  } else {
    host.evaluate = [&ranks](const CampaignTask& task) {
      ranks.begin();
      follow_campaign(ranks.get_communicator(), task);
      ranks.end();
    };
  }
  return host;
}

}  // namespace
}  // namespace unlatch::tools

int main(int argc, char** argv) {
  using namespace unlatch;
  constexpr const char* kVersion = "unlatch-mpi " UNLATCH_VERSION;
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
    std::puts(kVersion);
    return tools::kExitDone;
  }
  std::signal(SIGXFSZ, SIG_IGN);  // as in unlatch
  tools::CommandLine command_line(
      "Campaigns of unlatch on several machines: mpirun starts it, on as many ranks as there are processors.",
      "unlatch-mpi",
      "Exit codes: " + std::string(tools::kExitCodesText) +
          ".\nExample:\n  mpirun -n 64 unlatch-mpi campaign hil/scenarios/boosters/campaign.yaml --out boosters");
  command_line.set_version(kVersion);
  const tools::Command command = command_line.get_command();
  if (argc == 3 && std::strcmp(argv[1], "--manual") == 0) {  // for the build
    int code = tools::kExitDone;
    add_hosted_campaign(command, code, {});
    std::ofstream(argv[2]) << tools::build_manual(command, nullptr);
    return code;
  }
  command_line.get_command().require_verb();
  tools::Ranks ranks(argc, argv);
  int exit_code = tools::kExitDone;
  add_hosted_campaign(command, exit_code, tools::build_host(ranks));
  try {
    exit_code = tools::run_program(command_line, argc, argv, exit_code);
  } catch (const tools::OtherRankFailed& failed) {
    exit_code = failed.code;
  }
  return ranks.finish(exit_code);
}
