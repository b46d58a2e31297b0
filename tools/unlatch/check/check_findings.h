// Springs of a scenario at the start, as `check` shows them.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "hil/run/findings/spring_start.h"

namespace unlatch::tools {

void print_springs(std::FILE* to, const std::vector<hil::SpringStart>& springs);
nlohmann::ordered_json build_springs_json(const std::vector<hil::SpringStart>& springs);

}  // namespace unlatch::tools
