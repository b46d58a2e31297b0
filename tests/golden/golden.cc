// The golden program of the kernel: needs nothing but kernel/ and Eigen, so that it runs on every platform of the
// kernel. golden [--lanes NAME | --list-lanes]: prints the hashes of tests/data/golden.json; tools/determinism compares
// them over compilers and processors. golden --images FOLDER: writes the models' plan images for targets without
// operating system (tools/targets), and prints a line NAME TICKS for each.
#include <fstream>

#include "tests/golden/golden_distances.h"
#include "tests/golden/golden_models.h"
#include "tests/golden/golden_run.h"

namespace unlatch::test {
namespace {

int write_images(const std::string& folder) {
  for (const GoldenModel& golden : build_golden_models()) {
    const PlanResult compiled = compile_plan(golden.model, {.dt = golden.dt});
    const std::span<const std::byte> image = compiled.plan->get_image();
    std::ofstream file(folder + "/" + golden.model.name + ".plan", std::ios::binary);
    file.write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(image.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "%s: cannot write there\n", folder.c_str());
      return 1;
    }
    std::printf("%s %d\n", golden.model.name.c_str(), golden.ticks);
  }
  return 0;
}

}  // namespace
}  // namespace unlatch::test

int main(int argc, char** argv) {
  using namespace unlatch::test;
  if (argc == 3 && std::string_view(argv[1]) == "--images") return write_images(argv[2]);
  int first = 0;
  const unlatch::InstructionSet set = read_instruction_set(argc, argv, first);
  bool all = true;
  for (const GoldenModel& golden : build_golden_models()) {
    all &= print_golden_hashes(golden.model.name.c_str(), golden.model, golden.dt, golden.ticks, set);
  }
  print_distance_hashes();
  return all ? 0 : 1;
}
