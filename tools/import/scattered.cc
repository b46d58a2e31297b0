#include "tools/import/scattered.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace unlatch::tools {
namespace {

constexpr double kDependent = 1e-13;  // reciprocal condition below which points do not decide a value
constexpr double kNothing = 1e-9;     // of the inverse's entries

}  // namespace

ScatteredInterpolant::ScatteredInterpolant(ScatteredValues data, Radial radial, int neighbours)
    : data_(std::move(data)), radial_(radial), neighbours_(neighbours) {
  if (neighbours_ >= data_.points.cols()) neighbours_ = 0;
  if (neighbours_ > 0) return;
  const Eigen::PartialPivLU<Eigen::MatrixXd> factors(build_system(data_.points));
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(factors.rows(), data_.values.cols());
  values.topRows(data_.values.rows()) = data_.values;
  coefficients_ = factors.solve(values);
  inverse_ = factors.inverse();
}

double ScatteredInterpolant::calc_radial(double distance) const {
  return radial_ == Radial::kSmooth ? distance * distance * distance : distance;
}

// Radial functions of all points there, and the terms of the polynomial.
Eigen::RowVectorXd ScatteredInterpolant::build_row(const Eigen::MatrixXd& points, const Eigen::VectorXd& at) const {
  Eigen::RowVectorXd row(points.cols() + 1 + at.size());
  for (Eigen::Index i = 0; i < points.cols(); ++i) row[i] = calc_radial((points.col(i) - at).norm());
  row[points.cols()] = 1;
  row.tail(at.size()) = at.transpose();
  return row;
}

// One row for each point; then those by which the coefficients are orthogonal to the polynomial.
Eigen::MatrixXd ScatteredInterpolant::build_system(const Eigen::MatrixXd& points) const {
  const Eigen::Index count = points.cols(), terms = points.rows() + 1;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(count + terms, count + terms);
  for (Eigen::Index i = 0; i < count; ++i) system.row(i) = build_row(points, points.col(i));
  system.bottomLeftCorner(terms, count) = system.topRightCorner(count, terms).transpose();
  return system;
}

// In the order of their distance; equal ones in that of their numbers.
std::vector<int> ScatteredInterpolant::find_neighbours(const Eigen::VectorXd& at, int without) const {
  std::vector<std::pair<double, int>> by_distance;
  for (int i = 0; i < data_.points.cols(); ++i)
    if (i != without) by_distance.emplace_back((data_.points.col(i) - at).squaredNorm(), i);
  const std::ptrdiff_t count = std::min<std::ptrdiff_t>(neighbours_, std::ssize(by_distance));
  std::partial_sort(by_distance.begin(), by_distance.begin() + count, by_distance.end());
  std::vector<int> chosen;
  for (std::ptrdiff_t i = 0; i < count; ++i) chosen.push_back(by_distance[static_cast<std::size_t>(i)].second);
  return chosen;
}

std::optional<Eigen::RowVectorXd> ScatteredInterpolant::calc(const Eigen::VectorXd& at, int without) const {
  if (neighbours_ == 0) return build_row(data_.points, at) * coefficients_;
  const std::vector<int> chosen = find_neighbours(at, without);
  // About the place, of the size 1: such interpolants do not depend on that, but their rounding does.
  Eigen::MatrixXd local(data_.points.rows(), std::ssize(chosen));
  for (Eigen::Index i = 0; i < local.cols(); ++i)
    local.col(i) = data_.points.col(chosen[static_cast<std::size_t>(i)]) - at;
  local /= local.colwise().norm().maxCoeff();
  const Eigen::MatrixXd system = build_system(local);
  const Eigen::PartialPivLU<Eigen::MatrixXd> factors(system);
  if (!(factors.rcond() > kDependent)) return std::nullopt;
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(system.rows(), data_.values.cols());
  for (Eigen::Index i = 0; i < local.cols(); ++i) values.row(i) = data_.values.row(chosen[static_cast<std::size_t>(i)]);
  const Eigen::MatrixXd coefficients = factors.solve(values);
  return build_row(local, Eigen::VectorXd::Zero(at.size())) * coefficients;
}

std::vector<std::optional<Eigen::RowVectorXd>> ScatteredInterpolant::calc_left_out() const {
  const Eigen::Index count = data_.points.cols();
  std::vector<std::optional<Eigen::RowVectorXd>> errors;
  for (int i = 0; i < count; ++i) {
    if (neighbours_ > 0) {
      errors.push_back(calc(data_.points.col(i), i));
      if (errors.back()) *errors.back() -= data_.values.row(i);
      continue;
    }
    // Rippa's formula: what the others give there differs by the coefficient over the inverse's entry. That is 0 where
    // the others lie in one plane.
    const double own = inverse_(i, i), size = inverse_.row(i).head(count).cwiseAbs().maxCoeff();
    if (std::abs(own) > kNothing * size)
      errors.emplace_back(-coefficients_.row(i) / own);
    else
      errors.emplace_back(std::nullopt);
  }
  return errors;
}

}  // namespace unlatch::tools
