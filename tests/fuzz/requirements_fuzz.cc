// Requirements of other tools: ReqIF and CSV, and the part that an import writes of them, which is YAML.
#include <set>

#include "hil/scenario/yaml/yaml_document.h"
#include "tests/fuzz/fuzz.h"
#include "tools/requirements/requirement_list.h"

using namespace unlatch;

namespace {

const hil::Scenario& get_scenario() {
  static const hil::Scenario scenario = hil::load_scenario_text(R"(unlatch: 1
name: judged
step: {dt: 1 ms, until: 1 s}
bodies: {b: {mass: 2, inertia: [1, 1, 1]}}
requirements:
  - {id: near, velocity: {body: b}, at_most: 1}
  - {id: R2, velocity: {body: b}, at_most: 2}
)",
                                                                "judged.yaml");
  return scenario;
}

void check(const std::vector<tools::ListedRequirement>& list) {
  const tools::ImportedPart part = tools::write_part(list, get_scenario(), "f");
  const hil::YamlNode root = hil::parse_yaml(part.text);
  fuzz::require(root.find("unlatch_part") != nullptr, "a part without its header");
  fuzz::require(part.set + part.missing.size() == list.size(), "a requirement that is neither set nor missing");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::to_text(data, size);
  for (const auto read : {tools::read_reqif, tools::read_requirements}) {
    try {
      check(read(text, {}));
    } catch (const tools::RequirementError&) {
    } catch (const hil::YamlError&) {
      // More than YAML's bounds allow: the part is too large, which the scenario that includes it reports.
      fuzz::require(size > 100'000, "a part that is no YAML");
    }
  }
  return 0;
}
