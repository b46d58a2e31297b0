// Internals of the scenario loader: builds the tree of a scenario from its file, the included files, its templates and
// its `set`, so that the reader sees one plain scenario.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

// Builds the tree. Throws if a text is not YAML, as the only mistake; all other mistakes are added to `mistakes`.
YamlNode build_tree(ScenarioSources& sources, const std::string& file, Mistakes& mistakes);

// Replaces `templates` and `instances` by the entries that they describe.
void expand_templates(YamlNode& root, Mistakes& mistakes);

// Appends the entries of one section to another: mappings or lists. False if the two kinds differ.
bool append_section(YamlNode& to, YamlNode&& from);

// Sections that join entries from several files, or from templates.
const std::vector<std::string>& shared_sections();

}  // namespace unlatch::hil
