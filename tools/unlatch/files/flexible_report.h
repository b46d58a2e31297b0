// What a modes file gives: the flexible body that a scenario makes of it, in words and as JSON.
#pragma once

#include <cstdio>
#include <nlohmann/json_fwd.hpp>

#include "hil/scenario/flexible/flexible_body.h"

namespace unlatch::tools {

// Mass, inertia, and a table of the modes: frequencies in Hz, effective masses in kg, shares of the compliance at each
// marker in %. Selected modes have an asterisk.
void print_report(std::FILE* to, const hil::FlexibleStructure& body, const hil::FlexibleReport& report,
                  const hil::Modes& modes);

// The same, in SI units: schema, mass, centre, inertia, found, made, rigid, modes, markers.
nlohmann::ordered_json build_json(const hil::FlexibleStructure& body, const hil::FlexibleReport& report);

}  // namespace unlatch::tools
