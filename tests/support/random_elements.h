// Force elements, loops, sensors and events for random systems: every kind that a plan counts, in random numbers,
// gentle enough that the system can be stepped for some hundred ticks.
#pragma once

#include "tests/support/random.h"
#include "unlatch/model.h"

namespace unlatch::test {

// Of each kind up to a few; loops, flexible bodies, a planet with air, contacts and laws in some systems only.
void add_random_elements(Model& model, Random& random);

// A random tree with all of that. The same seed gives the same system.
Model build_random_system(std::uint64_t seed);

}  // namespace unlatch::test
