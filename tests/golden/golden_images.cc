// golden_images NAME=FILE=TICKS...: flies plan images, as `unlatch compile` writes them, with the commands of the
// start, and prints their hashes. An image that is refused ends the program with the reason.
#include <exception>

#include "tests/golden/golden_run.h"
#include "tests/support/image_file.h"

namespace unlatch::test {
namespace {

bool fly(const std::string& name, const std::string& file, std::int64_t ticks) {
  const ImageMemory image(read_image(file));
  PlanMemory memory;
  const OpenedPlan opened = open_plan(image.get(), memory);
  if (!opened.plan) throw std::runtime_error(file + ": " + get_status_text(opened.status));
  const Plan& plan = *opened.plan;
  Block state_memory(plan.get_state_bytes()), workspace_memory(plan.get_workspace_bytes());
  State state(plan, state_memory.get());
  Workspace workspace(plan, workspace_memory.get());
  init_state(plan, state);
  const Inputs inputs{plan.get_initial_commands()};
  return print_golden_hashes(
      name.c_str(), [&] { return step(plan, inputs, state, workspace); }, state, workspace, ticks);
}

}  // namespace
}  // namespace unlatch::test

int main(int argc, char** argv) {
  bool all = true;
  for (int i = 1; i < argc; ++i) {
    const std::string text = argv[i];
    const std::size_t first = text.find('='), last = text.rfind('=');
    try {
      if (first == last) throw std::runtime_error(text + ": not NAME=FILE=TICKS");
      all &= unlatch::test::fly(text.substr(0, first), text.substr(first + 1, last - first - 1),
                                std::stoll(text.substr(last + 1)));
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      all = false;
    }
  }
  return all ? 0 : 1;
}
