// Velocities of a system in one vector: of each body other than markers v in W and w in body axes, then the modal
// rates. For linear models; not part of the step.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kernel/plan/plan_data.h"

namespace unlatch {

class Velocities {
 public:
  explicit Velocities(const PlanData& plan);  // keeps a reference

  [[nodiscard]] Eigen::Index size() const { return size_; }
  // Places in the vector: of six numbers of a body, kNone of a marker; of a flexible body's modal rates.
  [[nodiscard]] Eigen::Index first(std::size_t body) const { return first_[body]; }
  [[nodiscard]] Eigen::Index modal(std::size_t flexible) const { return modal_[flexible]; }

  [[nodiscard]] Eigen::VectorXd read(const State& state) const;
  void write(const Eigen::VectorXd& v, State& state) const;
  // Moves a state along a velocity for a time, s: positions, attitudes by rotations about fixed axes, modal
  // coordinates.
  void move(const Eigen::VectorXd& v, double time, State& state) const;

 private:
  const PlanData& plan_;
  std::vector<Eigen::Index> first_, modal_;
  Eigen::Index size_ = 0;
};

}  // namespace unlatch
