// Random systems for property tests: a tree of bodies under joints of every kind, in a state that satisfies the joints'
// initial modes. The same seed and options give the same system, bit for bit, on every machine.
#pragma once

#include <cstdint>

#include "tests/support/random.h"
#include "unlatch/model.h"

namespace unlatch::test {

struct RandomModelOptions {
  enum class Shape { kAny, kChain, kStar, kTree };  // kAny: one of the others
  Shape shape = Shape::kAny;
  int bodies = 0;                  // number of bodies; 0: 1 … 60
  double mass_ratio = 10;          // heaviest body's mass over the lightest's, at most; inertias follow
  double grounded_chance = 0.3;    // probability of a joint between the ground and the tree's first body
  double first_mode_chance = 0.7;  // of starting in a joint's full mode, modes[0], not in another
  bool common_kinds = false;       // joints that every multibody program has: none that is free or composed of odd rows
};

// Builds a system. Every joint has several modes: its kind, part of the kind's rows, free, weld. Bases and followers
// come in both directions, body numbers in no order of depth; frames are arbitrary; half of the joints leave
// follower_axes out.
Model build_random_model(std::uint64_t seed, const RandomModelOptions& options = {});

// Builds a joint that closes a loop: from a random point of the base to its present place in the follower. It has no
// modes yet.
Joint build_closing_joint(const Model& model, int base, int follower, Random& random);

}  // namespace unlatch::test
