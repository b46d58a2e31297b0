// What this version of the program stands on: VALIDATION.md and the table of promises and tests of tests/README.md,
// which are compiled in.
#pragma once

#include <nlohmann/json.hpp>

namespace unlatch::tools {

// {program, commit, compiler, verified: [{what, compared_with, agreement}], promises: [{group, promise, test}],
// flights: [paragraphs], not_validated, known_to_be_wrong: [sentences]}
nlohmann::ordered_json build_verification_json();

}  // namespace unlatch::tools
