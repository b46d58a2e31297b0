#include "tools/import/hull.h"

#include <Eigen/QR>
#include <algorithm>
#include <limits>
#include <vector>

namespace unlatch::tools {
namespace {

constexpr double kHullRounding = 1e-14;  // of squares of distances and of weights
constexpr int kMostTurns = 1000;         // a few times the number of dimensions are usual

// Points of which the nearest one is a mean, and their weights.
struct Corral {
  std::vector<int> members;
  std::vector<double> weights;

  void erase_unused() {
    for (std::size_t i = members.size(); i-- > 0;)
      if (!(weights[i] > kHullRounding) && members.size() > 1) {
        members.erase(members.begin() + static_cast<std::ptrdiff_t>(i));
        weights.erase(weights.begin() + static_cast<std::ptrdiff_t>(i));
      }
  }
};

Eigen::VectorXd calc_mean(const Eigen::MatrixXd& points, const Corral& corral) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(points.rows());
  for (std::size_t i = 0; i < corral.members.size(); ++i) mean += corral.weights[i] * points.col(corral.members[i]);
  return mean;
}

// Weights, some of which may be negative, of the point nearest to `to` in the plane through the members.
Eigen::VectorXd solve_plane(const Eigen::MatrixXd& points, const Eigen::VectorXd& to, const Corral& corral) {
  const auto count = static_cast<Eigen::Index>(corral.members.size());
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(count);
  if (count == 1) return weights;
  Eigen::MatrixXd edges(points.rows(), count - 1);
  for (Eigen::Index i = 1; i < count; ++i)
    edges.col(i - 1) = points.col(corral.members[static_cast<std::size_t>(i)]) - points.col(corral.members[0]);
  weights.tail(count - 1) = edges.colPivHouseholderQr().solve(to - points.col(corral.members[0]));
  weights[0] = 1 - weights.tail(count - 1).sum();
  return weights;
}

// Moves the weights towards those of the plane, as far as all stay positive. True if that is the whole way.
bool move(const Eigen::VectorXd& wanted, Corral& corral) {
  double part = 1;
  for (std::size_t i = 0; i < corral.weights.size(); ++i) {
    const double own = corral.weights[i], other = wanted[static_cast<Eigen::Index>(i)];
    if (other < kHullRounding && own > other) part = std::min(part, own / (own - other));
  }
  for (std::size_t i = 0; i < corral.weights.size(); ++i)
    corral.weights[i] += part * (wanted[static_cast<Eigen::Index>(i)] - corral.weights[i]);
  return part >= 1;
}

}  // namespace

NearestInHull find_nearest_in_hull(const Eigen::MatrixXd& points, const Eigen::VectorXd& to, int without) {
  // The point farthest along `direction`, seen from `to`.
  const auto find_farthest = [&](const Eigen::VectorXd& direction) {
    Eigen::VectorXd along = points.transpose() * direction;
    if (without >= 0) along[without] = -std::numeric_limits<double>::infinity();
    Eigen::Index best = 0;
    along.maxCoeff(&best);
    return static_cast<int>(best);
  };
  Corral corral{{without == 0 && points.cols() > 1 ? 1 : 0}, {1.0}};
  Eigen::VectorXd mean = calc_mean(points, corral);
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const Eigen::VectorXd away = to - mean;
    const int next = find_farthest(away);
    // Nothing lies nearer: the plane through the mean, across `away`, has all points on its other side.
    if (away.dot(points.col(next) - mean) <= kHullRounding) break;
    if (std::ranges::find(corral.members, next) != corral.members.end()) break;
    corral.members.push_back(next);
    corral.weights.push_back(0);
    while (!move(solve_plane(points, to, corral), corral)) corral.erase_unused();
    corral.erase_unused();
    mean = calc_mean(points, corral);
  }
  return {mean, (to - mean).norm()};
}

}  // namespace unlatch::tools
