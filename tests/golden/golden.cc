// The golden program of the kernel: needs nothing but kernel/ and Eigen, so that it runs on every platform of the
// kernel. golden [--lanes NAME | --list-lanes]: prints the hashes of tests/data/golden.json; tools/determinism compares
// them over compilers and processors.
#include "tests/golden/golden_distances.h"
#include "tests/golden/golden_models.h"
#include "tests/golden/golden_run.h"

int main(int argc, char** argv) {
  using namespace unlatch::test;
  int first = 0;
  const unlatch::InstructionSet set = read_instruction_set(argc, argv, first);
  bool all = true;
  for (const GoldenModel& golden : build_golden_models()) {
    all &= print_golden_hashes(golden.model.name.c_str(), golden.model, golden.dt, golden.ticks, set);
  }
  print_distance_hashes();
  return all ? 0 : 1;
}
