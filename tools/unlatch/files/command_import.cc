// unlatch import: another tool's description as a starting point for a scenario.
#include <filesystem>

#include "hil/run/run.h"
#include "hil/scenario/base/module.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/import/guard.h"
#include "tools/import/imported.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/files/verbs.h"

namespace unlatch::tools {
namespace {

struct ImportOptions {
  std::string file, out;
  bool fixed_base = false, force = false;
};

const ImportReaders& load_readers() {
  return *hil::find_function<const ImportReaders*()>("unlatch-import", "unlatch_get_import_readers")();
}

// Loads the scenario that was made. Its mistakes are those of the imported file: throws ImportError with their lines
// there.
hil::Scenario load_made(const WrittenScenario& made) {
  try {
    return hil::load_scenario_text(made.text, "the scenario that it makes");
  } catch (const hil::ScenarioError& error) {
    std::string text;
    for (const hil::ScenarioMistake& mistake : error.mistakes) {
      const int line = made.find_line(mistake.mark.line);
      text += (text.empty() ? "" : "\n  ") + (line > 0 ? "line " + std::to_string(line) + ": " : std::string()) +
              mistake.what + "; " + mistake.mend;
    }
    throw ImportError(text);
  }
}

int run(const ImportOptions& options) {
  const std::filesystem::path path(options.file);
  const std::string text = read_xml(options.file);
  const bool is_urdf = path.extension() == ".urdf" || text.find("<robot") != std::string::npos;
  if (!is_urdf && text.find("<mujoco") == std::string::npos) {
    throw ImportError("is neither a URDF (<robot>) nor an MJCF (<mujoco>)");
  }
  const ImportReaders& readers = load_readers();
  if (!is_urdf && readers.read_mjcf == nullptr) {
    std::fprintf(stderr,
                 "unlatch import: this program was built without MuJoCo; install libmujoco-dev and build again: "
                 "cmake --preset release && tools/build\n");
    return kExitEnvironment;
  }
  if (!options.force && options.out != "-" && std::filesystem::exists(options.out)) {
    refuse_option("--out", options.out + " exists; --force replaces it");
  }
  const WrittenScenario scenario = WrittenScenario::unpack(compute_apart([&] {
    return write_scenario(is_urdf ? readers.read_urdf(text, path.filename().string(), options.fixed_base)
                                  : readers.read_mjcf(options.file))
        .pack();
  }));
  // An unphysical model is reported like that of any scenario, and not written.
  const hil::Scenario checked = load_made(scenario);
  hil::build_simulation(checked);
  write_text(scenario.text, options.out);
  std::fprintf(stderr, "%s: %s, %s; its first lines say what was left out\n", options.out.c_str(),
               count(checked.model.bodies.size(), "body").c_str(), count(checked.model.joints.size(), "joint").c_str());
  return kExitDone;
}

}  // namespace

void add_import(Command app, int& exit_code) {
  auto options = std::make_shared<ImportOptions>();
  Command command = app.add_verb(
      "import",
      "Converts a URDF or MJCF file to a scenario, as a starting point. Converted: bodies with mass and inertia, "
      "joints (fixed, revolute, continuous, prismatic, planar, floating; MJCF: hinge, slide, ball, free, two crossed "
      "hinges, connect and weld), springs and dampers of joints, shapes (box, cylinder, sphere, capsule; meshes of "
      "MJCF "
      "as convex hulls), gravity. Left out, and listed at the top of the file: ranges, dry friction, actuators, "
      "tendons, sensors, contacts, meshes of a URDF. The bodies are at the file's zero configuration, at rest.",
      "unlatch import arm.urdf --fixed-base --out arm.yaml\n"
      "unlatch import pendulum.xml --out pendulum.yaml && unlatch run pendulum.yaml");
  command.add_option("FILE", options->file, "URDF (.urdf) or MJCF (.xml)").required();
  command.add_option("--out", options->out, "scenario to write (.yaml); - for standard output")
      .required()
      .type_name("FILE");
  command.add_flag("--fixed-base", options->fixed_base, "URDF: a root link with mass is welded to the ground");
  command.add_flag("--force", options->force, "overwrites an existing file");
  command.callback([options, &exit_code] {
    try {
      exit_code = run(*options);
    } catch (const ImportError& error) {
      std::fprintf(stderr, "%s: %s\n", options->file.c_str(), error.what());
      exit_code = kExitUsage;
    }
  });
}

}  // namespace unlatch::tools
