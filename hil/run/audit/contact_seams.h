// ContactSeams: shapes that two others push where there is one surface. At the seam of two boxes that lie flush, or
// where shapes of one surface overlap, each shape has a force of its own, by its own depth: together they push up to
// twice as hard as one shape would. A sphere between two walls touches both, too, and rightly so: there neither point
// of contact lies on the other wall. So do the two ends of a bar on two boxes. Looked at at the knots of each step and,
// since the second shape's depth begins at 0 where it touches, halfway between them.
#pragma once

#include <compare>
#include <span>
#include <utility>
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
  // Contacts with such a shape in the latest step, the worst of each; valid until the next call.
  std::span<const ContactSeam> update();

 private:
  // A pair of a contact: a shape of one body, and one of the other body that pushes it.
  struct Pair {
    int contact = 0, number = 0;  // in the model; among the pairs of the contact
    // The pushed shape, whichever contact it is of, and the body that it may touch with several shapes.
    struct Pushed {
      int body = kGround, surface = kGround;  // `surface`: the other body
      std::size_t shape = 0;                  // among all shapes that were met so far
      auto operator<=>(const Pushed&) const = default;
    };
    Pushed pushed;
    geometry::ShapeGroup own, surface;  // one shape each
  };
  // Where the bodies are, and the state that tells which pairs are closed.
  struct Instant {
    const State& from;
    const State& to;
    bool halfway = false;
  };
  void watch(int contact, bool own_is_base);
  std::size_t find_shape(int body, const geometry::Shape& shape);
  void look(const Instant& instant);
  void add(const Pair& shallow, double part);

  const Simulation& simulation_;
  geometry::ShapeGroup point_;                           // where two shapes are asked for a point of contact
  std::vector<Pair> pairs_;                              // those of one pushed shape follow one another
  std::vector<std::pair<int, geometry::Shape>> shapes_;  // with their bodies
  std::vector<ContactSeam> found_;
};

}  // namespace unlatch::hil
