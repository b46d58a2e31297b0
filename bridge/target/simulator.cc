// The simulator on a board without operating system, with flight software at the other end of a serial line, in
// lockstep. Prints, for comparison with a session on a computer (unlatch replay --hashes),
//   NAME TICK HASH       of the state, every 100 ticks and at the last one
#include "bridge/target/images.h"
#include "bridge/target/lockstep.h"
#include "kernel/targets/port.h"
#include "kernel/targets/text_line.h"
#include "unlatch/plan_image.h"

namespace unlatch::target {
namespace {

alignas(8) std::byte state_memory[UNLATCH_STATE_BYTES];  // both from CMakeLists.txt
alignas(64) std::byte workspace_memory[UNLATCH_WORKSPACE_BYTES];
PlanMemory plan_memory;

bool fail(const char* text) {
  TextLine() << "simulator: " << text << "\n";
  return false;
}

bool fly() {
  static SessionImage image;
  const auto* const begin = reinterpret_cast<const std::uint8_t*>(target_session);
  const auto* const end = reinterpret_cast<const std::uint8_t*>(target_session_end);
  if (const char* mistake = image.open({begin, end})) return fail(mistake);
  const OpenedPlan opened = open_plan({target_plan, target_plan_end}, plan_memory);
  if (!opened.plan) return fail(get_status_text(opened.status));
  const Plan& plan = *opened.plan;
  if (plan.get_state_bytes() > sizeof(state_memory) || plan.get_workspace_bytes() > sizeof(workspace_memory)) {
    TextLine() << "simulator: needs " << std::uint64_t{plan.get_state_bytes()} << " bytes of state and "
               << std::uint64_t{plan.get_workspace_bytes()} << " of workspace\n";
    return false;
  }
  static State state(plan, state_memory);
  static Workspace workspace(plan, workspace_memory);
  static FrameLine line;
  static Lockstep lockstep({plan, state, workspace, image, line});
  if (const char* mistake = lockstep.open()) return fail(mistake);
  return lockstep.run() || fail("the flight has ended with a fault");
}

}  // namespace
}  // namespace unlatch::target

int main() { unlatch::target::finish(unlatch::target::fly() ? 0 : 1); }
