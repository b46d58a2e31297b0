// ContactSeams: spheres that two shapes push where there is one surface. At the seam of two boxes that lie flush, or
// where shapes of one surface overlap, each shape has a force of its own, by its own depth: together they push up to
// twice as hard as one shape would. A sphere between two walls touches both, too, and rightly so: there neither point
// of contact lies on the other wall. Looked at where steps end.
#pragma once

#include <span>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {

struct ContactSeam {
  int contact = 0;  // in the model
  double part = 0;  // depth of the shape that adds its force, as a part of the other's
};

class ContactSeams {
 public:
  explicit ContactSeams(const Simulation& simulation);
  // Contacts with such a sphere at the present tick, the worst of each; valid until the next call.
  std::span<const ContactSeam> update();

 private:
  struct Pair {
    int number = 0;                      // among the pairs of the contact
    int sphere = 0;                      // among the shapes of its surface
    geometry::ShapeGroup ball, surface;  // one shape each
  };
  // A contact of spheres of one of its surfaces with several shapes of the other.
  struct Watched {
    int contact = 0;
    int ball = kGround, surface = kGround;  // bodies
    std::vector<Pair> pairs;
  };
  void watch(int contact, bool balls_are_base);

  const Simulation& simulation_;
  geometry::ShapeGroup point_;  // where two shapes are asked for a point of contact
  std::vector<Watched> watched_;
  std::vector<ContactSeam> found_;
};

}  // namespace unlatch::hil
