// Runs in the lanes of one plan: where each of them lies in it.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "kernel/compile/join.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/bundle.h"

namespace unlatch {

// `count` items of a member's list, from `own` on, are those of the joined plan's list from `joined` on.
struct Stretch {
  std::int32_t own = 0, joined = 0, count = 0;
};

// A run: where its items begin in each list of the joined plan.
struct BundleMember {
  std::int32_t body, joint, event, signal, pair, one_sided, bearing, sensor, quantity, channel, load, friction, law,
      law_place, table, aerodynamics;
  std::array<Stretch, kElementKinds> elements;  // by kind
  std::array<Stretch, 2> auxiliary;             // masses burnt; totals of contacts
  std::vector<std::int32_t> coordinates;        // each of its driven coordinates in the joined plan
};

struct BundleData {
  explicit BundleData(Plan plan_in);

  Plan plan;  // of all members, see compile/join.h
  std::vector<BundleMember> members;
  std::vector<double> commands;  // of all members' channels
  std::unique_ptr<std::byte, void (*)(std::byte*)> memory;
  Workspace workspace;  // its kept state is that of all members at the end of their latest step side by side
};

}  // namespace unlatch
