// The verdict of a run on its requirements, and its separations: as tables, as JSON, as JUnit XML.
#pragma once

#include <string>

#include "tools/unlatch/results/report.h"

namespace unlatch::tools {

// All requirements are met: what the exit code says beside the run's status.
bool is_met(const RunReport& report);

void print_requirements(std::FILE* to, const RunReport& report);
void print_separations(std::FILE* to, const RunReport& report);
nlohmann::ordered_json build_requirements_json(const RunReport& report);
nlohmann::ordered_json build_separations_json(const RunReport& report);

// One test suite: a case for the run itself, which is an error unless its status is "ok", and one for each requirement.
// The format is that of Ant's JUnit task, as test servers read it. Empty target: nothing is written.
void write_junit(const RunReport& report, const std::string& target);

}  // namespace unlatch::tools
