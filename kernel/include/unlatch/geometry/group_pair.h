// The least distance of two groups of shapes that move.
#pragma once

#include <cstddef>
#include <vector>

#include "unlatch/geometry.h"

namespace unlatch::geometry {

// m, at most by which the distance of two groups changes with the place of one of them as seen from the other: `centre`
// and attitude of its bounding sphere with the radius `bound`. The difference of two attitudes moves a point at
// distance r from the centre by at most r |R − R'| / √2 (Frobenius).
double calc_way(const Vec3& from_centre, const Mat3& from_R, const Vec3& to_centre, const Mat3& to_R,
                double bound) noexcept;

// The box about a group along the axes of W, m; infinite where the group is.
struct Extent {
  Vec3 least{0, 0, 0};  // corner of the least coordinates, m
  Vec3 most{0, 0, 0};   // corner of the greatest, m
};
// That of a group whose body is at a place: the boxes about its shapes, so that rounding may cut off some 1e-16 of it.
Extent calc_extent(const ShapeGroup& group, const Placement& at) noexcept;

// Two groups whose least distance is asked for again and again while they move. Keeps a lower bound of each pair of
// shapes; less the way since it was computed, it skips the pair, which changes no bit of a result. Not for two threads
// at once.
class GroupPair {
 public:
  // May allocate, later not.
  GroupPair(ShapeGroup a, ShapeGroup b);

  // The two groups.
  [[nodiscard]] const ShapeGroup& get_a() const { return a_; }
  [[nodiscard]] const ShapeGroup& get_b() const { return b_; }
  // As calc_distance() of the two.
  GroupDistance calc_distance(const Placement& at_a, const Placement& at_b) noexcept;

 private:
  // The bounded side of the two, as seen from the other.
  struct Seen {
    Vec3 centre{0, 0, 0};  // m
    Mat3 R = kIdentity3;
  };
  [[nodiscard]] Seen calc_seen(const Placement& at_a, const Placement& at_b) const noexcept;

  // Adds the way of the groups to where they are seen now. `bound`: radius of the bounded side, m.
  void add_way(const Seen& seen, double bound) noexcept;

  ShapeGroup a_, b_;
  Seen latest_{};               // at the latest call
  double way_ = 0;              // m, since the bounds were cleared
  int calls_ = 0;               // since then
  std::vector<double> bounds_;  // m, of each pair of shapes, and the way up to where it was computed
  std::size_t nearest_ = 0;     // pair of the latest result
};

}  // namespace unlatch::geometry
