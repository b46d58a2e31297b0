// Scenarios to begin with, and the schema by which editors check them: the files of tools/unlatch/files/starters and
// hil/scenarios/unlatch.schema.json as they were when the program was built.
#pragma once

#include <string>
#include <vector>

namespace unlatch::tools {

struct Starter {
  std::string name, text;  // in the text `name: NAME` is to be replaced
};
const std::vector<Starter>& get_starters();
const std::string& get_schema();

}  // namespace unlatch::tools
