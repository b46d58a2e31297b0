// Models of the golden program: every feature of a step, described with nothing but the kernel and exact arithmetic, so
// that every compiler and processor starts from the same bits.
#pragma once

#include <vector>

#include "unlatch/model.h"

namespace unlatch::test {

struct GoldenModel {
  Model model;  // its name is the name in the hashes
  double dt;    // s
  int ticks;    // long enough for every event of the model
};

std::vector<GoldenModel> build_golden_models();

// One of these: pushers, stops, cords, friction and impulses.
Model build_pushers();

}  // namespace unlatch::test
