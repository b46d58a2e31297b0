// The point of a convex hull that is nearest to a given one, in up to six dimensions (Wolfe, "Finding the nearest point
// in a polytope", Mathematical Programming 11, 1976). No faces of the hull are built, whose number grows with the power
// of half the dimensions.
//
// Cost: some tens of passes over the points.
#pragma once

#include <Eigen/Core>

namespace unlatch::tools {

struct NearestInHull {
  Eigen::VectorXd point;  // in the hull
  double distance = 0;    // to it
};

// `points`: one in each column, at least one, of a size near 1. `without`: one that does not count, or -1. Rounding
// leaves some 1e-12.
NearestInHull find_nearest_in_hull(const Eigen::MatrixXd& points, const Eigen::VectorXd& to, int without = -1);

}  // namespace unlatch::tools
