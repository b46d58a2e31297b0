#include "kernel/targets/cost.h"
#include "kernel/targets/port.h"

namespace unlatch::target {

void begin_primitives(const PlanData&) {}
std::uint64_t begin_step() { return read_counter(); }
std::uint64_t end_step(std::uint64_t begin) { return read_counter() - begin; }
void print_primitives(const char*) {}

}  // namespace unlatch::target
