// unlatch preflight: checks whether this machine is ready for a hard-real-time run, and says how to improve it.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "hil/session/realtime/preflight.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/options/pacing_options.h"
#include "tools/unlatch/run/verbs.h"

namespace unlatch::tools {
namespace {

using Verdict = hil::PreflightCheck::Verdict;

struct PreflightOptions {
  std::string json;
  bool strict = false;
  int cpu = -1;
  bool no_trial = false;
  bool fix = false;
};

Colour get_colour(Verdict verdict) {
  if (verdict == Verdict::kGood) return Colour::kGreen;
  return verdict == Verdict::kMissing ? Colour::kRed : Colour::kYellow;
}

void print(std::FILE* to, const std::vector<hil::PreflightCheck>& checks) {
  for (const hil::PreflightCheck& check : checks) {
    std::string verdict = hil::kVerdictNames[static_cast<std::size_t>(check.verdict)];
    verdict.resize(8, ' ');
    std::fprintf(to, "%s %s: %s\n", paint(to, get_colour(check.verdict), verdict).c_str(), check.name.c_str(),
                 check.found.c_str());
    if (!check.cost.empty()) std::fprintf(to, "         cost: %s\n", check.cost.c_str());
    if (!check.mend.empty()) std::fprintf(to, "         mend: %s\n", check.mend.c_str());
  }
}

int run(const PreflightOptions& options) {
  hil::MachineFacts facts = hil::read_machine_facts();
  if (!options.no_trial) {
    for (const std::string& refused : hil::try_machine(facts, options.cpu))
      std::fprintf(stderr, "%s\n", refused.c_str());
  }
  if (options.fix) {
    std::fputs(hil::print_fixes(facts, options.cpu).c_str(), stdout);
    return kExitDone;
  }
  const std::vector<hil::PreflightCheck> checks = hil::judge(facts);
  const auto count = [&checks](Verdict verdict) {
    return std::count_if(checks.begin(), checks.end(), [=](const auto& check) { return check.verdict == verdict; });
  };
  const std::string verdict = count(Verdict::kMissing) > 0 ? "missing" : count(Verdict::kCosts) > 0 ? "costs" : "good";
  std::FILE* const to = get_people_stream(options.json);
  print(to, checks);
  std::fprintf(to, "\n%s: %ld good, %ld with a cost, %ld missing, %ld unknown\n",
               tools::count(checks.size(), "check").c_str(), static_cast<long>(count(Verdict::kGood)),
               static_cast<long>(count(Verdict::kCosts)), static_cast<long>(count(Verdict::kMissing)),
               static_cast<long>(count(Verdict::kUnknown)));

  nlohmann::ordered_json json = {{"schema", 1}, {"verdict", verdict}, {"checks", nlohmann::ordered_json::array()}};
  for (const hil::PreflightCheck& check : checks) {
    json["checks"].push_back({{"name", check.name},
                              {"verdict", hil::kVerdictNames[static_cast<std::size_t>(check.verdict)]},
                              {"found", check.found},
                              {"cost", check.cost},
                              {"mend", check.mend}});
  }
  write_json(json, options.json);
  return options.strict && verdict != "good" ? kExitEnvironment : kExitDone;
}

}  // namespace

void add_preflight(Command app, int& exit_code) {
  auto options = std::make_shared<PreflightOptions>();
  Command command =
      app.add_verb("preflight",
                   "Checks whether this machine is ready for a hard-real-time run, and says how to improve it; changes "
                   "nothing. Loads one CPU for half a second to "
                   "measure other load on it.",
                   "unlatch preflight --cpu 3 --strict && unlatch preflight --json machine.json\n"
                   "unlatch preflight --cpu 3 --fix > fix.sh");
  command.add_json_option(options->json);
  command.add_option("--cpu", options->cpu, "CPU to test, that of the cyclic thread")
      .type_name("NUMBER")
      .check(check_cpu);
  command.add_flag("--no-trial", options->no_trial, "only reads system settings; does not load the CPU");
  command.add_flag("--fix", options->fix,
                   "prints the commands that mend it as a shell script, and nothing else; runs none");
  command.add_flag("--strict", options->strict, "exit code 3 unless all checks pass");
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
