// Inside of the scenario loader: the tree of a scenario from its file, the files that it includes, its templates and
// what `set` replaces, so that the reader sees one plain scenario.
#pragma once

#include <string>
#include <vector>

#include "hil/language/scenario_error.h"
#include "hil/language/scenario_sources.h"
#include "hil/language/yaml_document.h"

namespace unlatch::hil {

// A text that is not YAML is the only mistake then, and is thrown; all else is added to `mistakes`.
YamlNode build_tree(ScenarioSources& sources, const std::string& file, Mistakes& mistakes);

// Replaces `templates` and `instances` by the entries that they describe.
void expand_templates(YamlNode& root, Mistakes& mistakes);

// Appends the entries of one section to another: mappings and lists. False if they are not both one or the other.
bool append_section(YamlNode& to, YamlNode&& from);

// Sections whose entries from several files, or from templates, are put together.
const std::vector<std::string>& shared_sections();

}  // namespace unlatch::hil
