// Interpolation of values at scattered points by radial functions (Wendland, Scattered Data Approximation, 2005,
// chapters 8 and 11): a sum of φ(distance) about each point and a polynomial of degree 1, which passes through all
// points. Errors by leaving one point out at a time (Rippa, Advances in Computational Mathematics 11, 1999).
//
// Cost, with n points: n³ once; or, where only the k nearest ones count, k³ for each place.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace unlatch::tools {

enum class Radial {
  kSmooth,  // r³: continuous second derivatives
  kLinear,  // r: a corner at each point; swings less beside jumps
};

// Points in axes of a size near 1, and values there, several for each point.
struct ScatteredValues {
  Eigen::MatrixXd points;  // one in each column
  Eigen::MatrixXd values;  // one row for each point
};

class ScatteredInterpolant {
 public:
  // `neighbours`: of the points, those that count at a place; 0: all. Points must differ, and not lie in one plane.
  ScatteredInterpolant(ScatteredValues data, Radial radial, int neighbours);

  // The values there; nothing where the nearest points lie in one plane.
  [[nodiscard]] std::optional<Eigen::RowVectorXd> calc(const Eigen::VectorXd& at) const { return calc(at, -1); }
  // Per point what the other points give there, less the point's own values; nothing where they do not decide it.
  [[nodiscard]] std::vector<std::optional<Eigen::RowVectorXd>> calc_left_out() const;

 private:
  [[nodiscard]] std::optional<Eigen::RowVectorXd> calc(const Eigen::VectorXd& at, int without) const;
  [[nodiscard]] double calc_radial(double distance) const;
  [[nodiscard]] Eigen::MatrixXd build_system(const Eigen::MatrixXd& points) const;
  [[nodiscard]] Eigen::RowVectorXd build_row(const Eigen::MatrixXd& points, const Eigen::VectorXd& at) const;
  [[nodiscard]] std::vector<int> find_neighbours(const Eigen::VectorXd& at, int without) const;

  ScatteredValues data_;
  Radial radial_;
  int neighbours_;
  Eigen::MatrixXd inverse_, coefficients_;  // of all points, if all count
};

}  // namespace unlatch::tools
