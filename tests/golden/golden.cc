// The golden program of the kernel: needs nothing but kernel/ and Eigen, so that it runs wherever the kernel does.
// Prints the hashes that tests/data/golden.json has; tools/determinism compares them over compilers and processors.
#include "tests/golden/golden_models.h"
#include "tests/golden/golden_run.h"

int main() {
  bool all = true;
  for (const unlatch::test::GoldenModel& golden : unlatch::test::build_golden_models()) {
    all &= unlatch::test::print_golden_hashes(golden.model.name.c_str(), golden.model, golden.dt, golden.ticks);
  }
  return all ? 0 : 1;
}
