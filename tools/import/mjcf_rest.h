// What of a MuJoCo model the reader does not read: every field is compared with that of an empty model, so that nothing
// is left out because nobody has thought of it.
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace unlatch::tools {

// A sentence for each field that differs from MuJoCo's default, and that the reader neither reads nor remarks on
// itself.
std::vector<std::string> list_unread(const mjModel& model);

}  // namespace unlatch::tools
