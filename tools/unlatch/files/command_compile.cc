// unlatch compile: a scenario's plan as an image for targets without operating system.
#include <cstdio>
#include <memory>
#include <string>

#include "bridge/uart/session_image.h"
#include "hil/run/run.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/files/verbs.h"
#include "tools/unlatch/options/scenario_options.h"

namespace unlatch::tools {
namespace {

struct CompileOptions {
  ScenarioOptions scenario;
  std::string out, session;
};

void write_session(const CompileOptions& options, const hil::Scenario& scenario, const hil::Simulation& simulation) {
  const std::vector<std::uint8_t> image = bridge::build_session_image(scenario, simulation, calc_last_tick(scenario));
  write_text({reinterpret_cast<const char*>(image.data()), image.size()}, options.session);
  std::printf("%s: %s\n", options.session.c_str(), count(image.size(), "byte").c_str());
}

int run_compile(const CompileOptions& options) {
  check_output(options.out);
  check_output(options.session);
  const hil::Scenario scenario = load(options.scenario);
  if (!options.session.empty())
    if (const std::string obstacle = bridge::find_target_obstacle(scenario); !obstacle.empty())
      refuse_option("--session", obstacle);
  const std::unique_ptr<hil::Simulation> simulation = hil::build_simulation(scenario);
  const Plan& plan = simulation->plan();
  const std::span<const std::byte> image = plan.get_image();
  write_text({reinterpret_cast<const char*>(image.data()), image.size()}, options.out);
  std::printf("%s: %s, plan %016llx, %s of %g s\n", options.out.c_str(), count(image.size(), "byte").c_str(),
              static_cast<unsigned long long>(plan.get_hash()),
              count(static_cast<std::size_t>(calc_last_tick(scenario)), "tick").c_str(), scenario.dt);
  std::printf("state %s, workspace %s on this machine, %s\n", count(plan.get_state_bytes(), "byte").c_str(),
              count(plan.get_workspace_bytes(), "byte").c_str(),
              count(plan.get_initial_commands().size(), "command channel").c_str());
  if (!options.session.empty()) write_session(options, scenario, *simulation);
  return kExitDone;
}

}  // namespace

void add_compile(Command app, int& exit_code) {
  auto options = std::make_shared<CompileOptions>();
  Command command = app.add_verb(
      "compile", "Writes a scenario's compiled plan as an image that targets without operating system use in place.",
      "unlatch compile hil/scenarios/boosters/reference.yaml --out boosters.plan");
  add_scenario_options(command, options->scenario);
  command.add_option("--out", options->out, "plan image (kernel/TARGETS.md)").required();
  command.add_option("--session", options->session,
                     "what the session announces, for a target in the loop with flight software (bridge/target)");
  command.callback([options, &exit_code] { exit_code = run_compile(*options); });
}

}  // namespace unlatch::tools
