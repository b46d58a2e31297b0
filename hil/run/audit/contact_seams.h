// ContactSeams: spheres that two shapes push where there is one surface. At the seam of two boxes that lie flush, or
// where shapes of one surface overlap, each shape has a force of its own, by its own depth: together they push up to
// twice as hard as one shape would. A sphere between two walls touches both, too, and rightly so: there neither point
// of contact lies on the other wall. Looked at where steps end.
#pragma once

#include <compare>
#include <span>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {

struct ContactSeam {
  int contact = 0;  // in the model: that of the shape that adds its force
  double part = 0;  // depth of the shape that adds its force, as a part of the other's
};

class ContactSeams {
 public:
  explicit ContactSeams(const Simulation& simulation);
  // Contacts with such a sphere at the present tick, the worst of each; valid until the next call.
  std::span<const ContactSeam> update();

 private:
  // A pair of a contact: a sphere, and a shape of another kind of the other body.
  struct Pair {
    int contact = 0, number = 0;  // in the model; among the pairs of the contact
    // The sphere, whichever contact it is of, and the body that it may touch with several shapes.
    struct Sphere {
      int body = kGround, surface = kGround;  // `surface`: the other body
      double x = 0, y = 0, z = 0, radius = 0;
      auto operator<=>(const Sphere&) const = default;
    };
    Sphere sphere;
    geometry::ShapeGroup ball, surface;  // one shape each
  };
  void watch(int contact, bool balls_are_base);
  void add(const Pair& shallow, double part);

  const Simulation& simulation_;
  geometry::ShapeGroup point_;  // where two shapes are asked for a point of contact
  std::vector<Pair> pairs_;     // those of one sphere follow one another
  std::vector<ContactSeam> found_;
};

}  // namespace unlatch::hil
