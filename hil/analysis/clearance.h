// Smallest distance between bodies, from their shapes. For reports, off the cyclic thread: it allocates.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "hil/scenario/shapes.h"

namespace unlatch::hil {

struct Pose {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
};

struct Clearance {
  int a = 0, b = 0;                                           // bodies
  double now = std::numeric_limits<double>::infinity();       // m, at the last update; 0 if they touch or overlap
  double smallest = std::numeric_limits<double>::infinity();  // m, of all updates
  double time = 0;                                            // s, when it was smallest
  // Times at which it is no greater than the smallest, to 1e-6 m: one instant, or the distance does not change for
  // long.
  struct Tie {
    double from = 0, to = 0;  // s
    int count = 0;            // knots of the motion
  };
  Tie tie{};
  // From the time at which nothing joins the two any longer; absent for bodies that were never joined, or still are.
  struct AfterRelease {
    double from, smallest, time;  // s, m, s
  };
  std::optional<AfterRelease> after_release{};
  double rate = 0;  // m/s, at the last update; below 0 they close
};

// Spheres and capsules against each other: closed form, exact to rounding. All else: FCL's convex distance (GJK), to
// about 1e-6 m where faces are flat; across the curved side of a cone or a cylinder it ends its search earlier, and a
// curve over time shows steps of some 1e-3 m.
class ClearanceMonitor {
 public:
  // `shapes`: of each body. Throws std::invalid_argument if a pair names a body without shapes.
  ClearanceMonitor(const std::vector<std::pair<int, int>>& pairs, const std::vector<std::vector<Shape>>& shapes);
  ~ClearanceMonitor();
  ClearanceMonitor(ClearanceMonitor&&) noexcept;
  ClearanceMonitor& operator=(ClearanceMonitor&&) noexcept;

  void update(double time, const std::vector<Pose>& poses);  // of all bodies, at `time`
  // m, of a pair by its number, with its bodies at these poses.
  double calc(std::size_t pair, const Pose& a, const Pose& b);
  // Closed forms serve the pair; if not, its distances have noise of some 1e-6 m.
  bool is_exact(std::size_t pair) const;
  const std::vector<Clearance>& get() const { return clearances_; }

 private:
  struct Geometry;
  std::vector<Clearance> clearances_;
  std::unique_ptr<Geometry> geometry_;
};

}  // namespace unlatch::hil
