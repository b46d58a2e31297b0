// A finding about a scenario: a fact that an engineer would want to know before the run.
#pragma once

#include <string>

namespace unlatch::hil {

// A fact to check; the run follows the scenario all the same. `where`: a key of Scenario::marks, or empty.
struct Finding {
  std::string name;  // branch, start, never, overlap, points, modes, direction, free_spring, inertia,
                     // contact, friction, step, corner, law, loops, outputs, trivial, unread
  std::string where, text;
};

// Key of an element in Scenario::marks: "body 'core'".
inline std::string quoted(const char* kind, const std::string& name) { return std::string(kind) + " '" + name + "'"; }

}  // namespace unlatch::hil
