// ContactJumps: points of contact that jump. Each pair of shapes has one point of contact, the deepest. Of a face or a
// straight line that lies on another body it jumps from end to end as the body tilts through parallel, and the force
// with it: the body moves as if it stood on one end, and on which one depends on the step. Points of round shapes do
// not jump: between two ticks they move by what the bodies slip and turn.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/geometry.h"

namespace unlatch::hil {

// Jumps of the points of a contact since the run began.
struct ContactJumpSum {
  int contact = 0;    // in the model
  int count = 0;      // jumps
  double way = 0;     // m, the longest
  double turned = 0;  // rad/s, sum of what each jump changes if another end bears the force for one step: way · F_n ·
                      // dt, times the greater of both bodies' 1/inertia
  double fastest = 0;  // rad/s, the greatest angular velocity of either body
  // Part of the bodies' rotation that depends on which end bore the force.
  [[nodiscard]] double calc_part() const { return turned / (fastest + turned); }
};

class ContactJumps {
 public:
  explicit ContactJumps(const Simulation& simulation);
  // Contacts with a point that jumped in the latest step. Called after the initial state and after each step; valid
  // until the next call.
  std::span<const ContactJumpSum> update();

 private:
  // Witnesses of a closed pair in the axes of their bodies, m.
  struct Witnesses {
    Vec3 on_base{0, 0, 0}, on_follower{0, 0, 0};
  };
  struct Pair {
    int number = 0;                       // among the pairs of the contact
    geometry::ShapeGroup base, follower;  // one shape each
    std::optional<Witnesses> latest;      // while it is closed
  };
  struct Watched {
    int base = kGround, follower = kGround;  // bodies
    double mobility = 0;                     // 1/(kg m²), the greater of both bodies
    std::vector<Pair> pairs;                 // without spheres
    ContactJumpSum sum;
  };
  // How far the pair's point has jumped since the latest tick, m; 0 if it moved as bodies do.
  double calc_jump(const Watched& watched, Pair& pair) const;

  const Simulation& simulation_;
  std::vector<Watched> watched_;
  std::vector<ContactJumpSum> jumped_;
};

}  // namespace unlatch::hil
