// The whole KKT matrix at once, by Eigen's dense LDLT (pivoting) and sparse SimplicialLDLT. Assembled beforehand: only
// the factorisation and the solution are timed. The sparse one pivots on its diagonal in an order that ignores signs,
// which fails on the original matrix, so the block of its multipliers is −1e-8 instead of 0.
#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <stdexcept>

#include "bench/kkt.h"

namespace unlatch::bench {
namespace {

constexpr double kRegularisation = -1e-8;

using Triplets = std::vector<Eigen::Triplet<double>>;

Eigen::Index get_size(const KktSystem& system) {
  std::size_t rows = 6 * system.bodies.size();
  for (const KktJoint& joint : system.joints) rows += static_cast<std::size_t>(joint.count);
  return static_cast<Eigen::Index>(rows);
}

// Lower triangle: bodies first, then multipliers.
Triplets build_lower(const KktSystem& system, double corner) {
  Triplets entries;
  int row = 0;
  for (const KktBody& body : system.bodies) {
    for (int i = 0; i < 3; ++i) {
      entries.emplace_back(row + i, row + i, body.mass);
      for (int j = 0; j <= i; ++j) entries.emplace_back(row + 3 + i, row + 3 + j, body.inertia[3 * i + j]);
    }
    row += 6;
  }
  for (const KktJoint& joint : system.joints)
    for (int r = 0; r < joint.count; ++r, ++row) {
      for (int i = 0; i < 6; ++i) {
        if (joint.base >= 0) entries.emplace_back(row, 6 * joint.base + i, -joint.base_rows[6 * r + i]);
        entries.emplace_back(row, 6 * joint.follower + i, -joint.follower_rows[6 * r + i]);
      }
      entries.emplace_back(row, row, corner);
    }
  return entries;
}

Eigen::VectorXd build_right_side(const KktSystem& system) {
  Eigen::VectorXd b(get_size(system));
  Eigen::Index row = 0;
  for (const KktBody& body : system.bodies)
    for (const double force : body.force) b(row++) = force;
  for (const KktJoint& joint : system.joints)
    for (int r = 0; r < joint.count; ++r) b(row++) = -joint.bias[r];
  return b;
}

class WholeKkt : public KktSolver {
 public:
  explicit WholeKkt(const KktSystem& system) : b_(build_right_side(system)), x_(b_.size()) {
    std::size_t row = 6 * system.bodies.size();
    for (const KktJoint& joint : system.joints) {
      first_rows_.push_back(row);
      row += static_cast<std::size_t>(joint.count);
    }
  }

  const double* get_acceleration(int body) const override { return x_.data() + 6 * body; }
  const double* get_multipliers(int joint) const override {
    return x_.data() + first_rows_[static_cast<std::size_t>(joint)];
  }

 protected:
  Eigen::VectorXd b_, x_;
  std::vector<std::size_t> first_rows_;  // per joint
};

class Dense final : public WholeKkt {
 public:
  explicit Dense(const KktSystem& system) : WholeKkt(system), H_(Eigen::MatrixXd::Zero(b_.size(), b_.size())) {
    for (const auto& entry : build_lower(system, 0))
      H_(entry.row(), entry.col()) = H_(entry.col(), entry.row()) = entry.value();
  }
  void solve() override {
    ldlt_.compute(H_);
    x_ = ldlt_.solve(b_);
  }

 private:
  Eigen::MatrixXd H_;
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

class Sparse final : public WholeKkt {
 public:
  explicit Sparse(const KktSystem& system) : WholeKkt(system), H_(b_.size(), b_.size()) {
    const Triplets entries = build_lower(system, kRegularisation);
    H_.setFromTriplets(entries.begin(), entries.end());
    ldlt_.analyzePattern(H_);
  }
  void solve() override {
    ldlt_.factorize(H_);
    if (ldlt_.info() != Eigen::Success) throw std::runtime_error("SimplicialLDLT failed");
    x_ = ldlt_.solve(b_);
  }

 private:
  Eigen::SparseMatrix<double> H_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt_;
};

}  // namespace

std::unique_ptr<KktSolver> build_dense_solver(const KktSystem& system) { return std::make_unique<Dense>(system); }
std::unique_ptr<KktSolver> build_sparse_solver(const KktSystem& system) { return std::make_unique<Sparse>(system); }

}  // namespace unlatch::bench
