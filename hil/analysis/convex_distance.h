// Distances between convex shapes of any kind. FCL computes them, in a module: it takes milliseconds to load, and most
// runs have spheres and capsules alone, or no clearances.
#pragma once

#include <cstddef>
#include <memory>

#include "hil/analysis/clearance.h"
#include "hil/scenario/shapes.h"

namespace unlatch::hil {

class ConvexDistance {
 public:
  virtual ~ConvexDistance() = default;
  // The number by which `calc` knows the shape.
  virtual std::size_t add(const Shape& shape) = 0;
  // m, between two shapes whose bodies are at these poses; 0 if they touch or overlap.
  virtual double calc(std::size_t a, const Pose& at_a, std::size_t b, const Pose& at_b) = 0;
};

// Throws ModuleError.
std::unique_ptr<ConvexDistance> open_convex_distance();

}  // namespace unlatch::hil
