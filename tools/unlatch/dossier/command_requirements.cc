// unlatch requirements: to and from tools for requirements, as ReqIF or CSV.
#include <filesystem>
#include <memory>

#include "hil/scenario/language/scenario_sources.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/requirements/requirement_list.h"
#include "tools/unlatch/dossier/verbs.h"
#include "tools/unlatch/options/scenario_options.h"

namespace unlatch::tools {
namespace {

struct RequirementOptions {
  std::vector<std::string> arguments;  // export SCENARIO; import FILE SCENARIO
  std::string out, time = "1970-01-01T00:00:00Z";
  AttributeNames names;
  std::vector<std::string> overrides;
};

enum class Format { kReqif, kCsv };

Format get_format(const std::string& option, const std::string& path) {
  const std::string suffix = std::filesystem::path(path).extension().string();
  if (suffix == ".reqif" || suffix == ".reqifz" || suffix == ".xml") return Format::kReqif;
  if (suffix == ".csv") return Format::kCsv;
  refuse_option(option, path + ": the format follows from its name: .reqif or .csv");
}

// "" or the mistake: this is no xsd:dateTime.
std::string check_time(const std::string& text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  bool fits = text.size() >= kForm.size();
  for (std::size_t i = 0; fits && i < kForm.size(); ++i)
    fits = kForm[i] == '0' ? text[i] >= '0' && text[i] <= '9' : text[i] == kForm[i];
  if (fits) fits = text.find_first_not_of("0123456789.:+-Z", kForm.size()) == std::string::npos;
  return fits ? "" : "'" + text + "' is no time such as 2026-03-01T12:00:00Z";
}

int export_from(const RequirementOptions& options) {
  if (options.arguments.size() != 2)
    refuse_option("export", "one scenario: unlatch requirements export SCENARIO --out FILE.reqif");
  const Format format = get_format("--out", options.out);
  check_output(options.out);
  const hil::Scenario scenario = load({.path = options.arguments[1], .overrides = options.overrides});
  const std::vector<ListedRequirement> list = list_requirements(scenario);
  write_text(format == Format::kCsv ? write_requirements(list) : write_reqif(list, scenario.name, options.time),
             options.out);
  std::fprintf(stderr, "%s: %s\n", options.out.c_str(), count(list.size(), "requirement").c_str());
  return kExitDone;
}

std::string join(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kShown ? text + " and " + std::to_string(names.size() - kShown) + " more" : text;
}

int import_into(const RequirementOptions& options) {
  if (options.arguments.size() != 3)
    refuse_option("import", "a file and a scenario: unlatch requirements import FILE.reqif SCENARIO --out PART.yaml");
  const std::string& file = options.arguments[1];
  const Format format = get_format("import", file);
  check_output(options.out);
  const hil::Scenario scenario = load({.path = options.arguments[2], .overrides = options.overrides});
  ImportedPart part;
  try {
    const std::string text = hil::read_text_file(file, "file of requirements (.reqif, .csv)");
    const std::vector<ListedRequirement> list =
        format == Format::kCsv ? read_requirements(text, options.names) : read_reqif(text, options.names);
    part = write_part(list, scenario, std::filesystem::path(file).filename().string());
  } catch (const RequirementError& error) {
    std::fprintf(stderr, "%s: %s\n", file.c_str(), error.what());
    return kExitUsage;
  }
  write_text(part.text, options.out);
  std::fprintf(stderr, "%s: %s of %s set\n", options.out.c_str(), count(part.set, "requirement").c_str(),
               scenario.name.c_str());
  if (!part.missing.empty())
    std::fprintf(stderr, "note: the scenario does not judge %s: %s\n",
                 count(part.missing.size(), "requirement").c_str(), join(part.missing).c_str());
  if (!part.unknown.empty()) std::fprintf(stderr, "note: %s has no %s\n", file.c_str(), join(part.unknown).c_str());
  return kExitDone;
}

int run(const RequirementOptions& options) {
  const std::string& action = options.arguments[0];
  if (action == "export") return export_from(options);
  if (action == "import") return import_into(options);
  refuse_option(action, "what to do? unlatch requirements export …, or import …");
}

}  // namespace

void add_requirements(Command app, int& exit_code) {
  auto options = std::make_shared<RequirementOptions>();
  Command command =
      app.add_verb("requirements",
                   "Takes requirements to tools for requirements and back, as ReqIF 1.2 or CSV. `export SCENARIO` "
                   "writes identifier, "
                   "text, parent, rationale, and the criterion by which runs judge. `import FILE SCENARIO` writes a "
                   "part that sets text, "
                   "parent and rationale of the scenario's requirements, by their identifiers; the scenario includes "
                   "it. What it does "
                   "not judge is listed in comments. The same scenario gives the same bytes.",
                   "unlatch requirements export hil/scenarios/boosters/scenario.yaml --out boosters.reqif\n"
                   "unlatch requirements import system.reqif scenario.yaml --out requirements.yaml");
  command.add_option("ARGUMENTS", options->arguments, "export SCENARIO; or import FILE SCENARIO")
      .required()
      .expected(2, 3);
  command.add_option("--out", options->out, "of export: .reqif or .csv; of import: the part (.yaml)")
      .required()
      .type_name("FILE");
  command
      .add_option("--id", options->names.id,
                  "of import: attribute or column of the identifier (default: ReqIF.ForeignID, ID and the like)")
      .type_name("NAME");
  command.add_option("--text", options->names.text, "of the text (default: ReqIF.Text, Text, Object Text and the like)")
      .type_name("NAME");
  command
      .add_option("--parent", options->names.parent,
                  "of the parent (default: Parent; in ReqIF else the object above it)")
      .type_name("NAME");
  command.add_option("--rationale", options->names.rationale, "of the rationale (default: Rationale)")
      .type_name("NAME");
  command.add_option("--time", options->time, "of export: time of creation and last change in ReqIF")
      .type_name("TIME")
      .check(check_time)
      .default_shown();
  command.add_option("--set", options->overrides, "replaces one value of the scenario; repeatable")
      .type_name("PATH=VALUE")
      .repeatable();
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
