// Workspace: memory of a step for all that can be computed again, one per thread, and the outputs of the latest step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "unlatch/math.h"
#include "unlatch/model.h"
#include "unlatch/plan.h"

namespace unlatch {

struct WorkspaceData;  // kernel/plan/evaluation.h

// Numbers of a workspace that are a stride apart.
struct NumberColumn {
  std::int32_t first, stride;
};

// The multipliers of all joints, six each in the order of Row: 0 for rows that do not hold; N, N m.
class MultiplierView {
 public:
  MultiplierView() = default;
  // `numbers`: the workspace's; `joints`: the column of each joint.
  MultiplierView(double* numbers, std::span<const NumberColumn> joints) : numbers_(numbers), joints_(joints) {}
  // Number of multipliers, six for each joint.
  std::size_t size() const { return joints_.size() * kRows; }
  double operator[](std::size_t i) const { return get(i / kRows, i % kRows); }
  // Multiplier of a row of a joint.
  double& get(std::size_t joint, std::size_t row) const {
    return numbers_[joints_[joint].first + static_cast<std::ptrdiff_t>(row) * joints_[joint].stride];
  }

 private:
  double* numbers_ = nullptr;
  std::span<const NumberColumn> joints_;
};

// Accelerations of the bodies' origins, world axes, m/s², rad/s², by body.
class AccelerationView {
 public:
  AccelerationView() = default;
  // `numbers`: the workspace's; `bodies`: the column of each body.
  AccelerationView(const double* numbers, std::span<const NumberColumn> bodies) : numbers_(numbers), bodies_(bodies) {}
  // Number of bodies.
  std::size_t size() const { return bodies_.size(); }
  Spatial operator[](std::size_t body) const {
    const auto number = [&](std::ptrdiff_t i) { return numbers_[bodies_[body].first + i * bodies_[body].stride]; };
    return {{number(0), number(1), number(2)}, {number(3), number(4), number(5)}};
  }

 private:
  const double* numbers_ = nullptr;
  std::span<const NumberColumn> bodies_;
};

// Where a table was looked up beyond its ends at the end of the latest step.
struct TableExit {
  std::int32_t axis = kNone;                    // number of the first such axis; kNone: within all
  TableAxis::End end = TableAxis::End::kClamp;  // that was left
  double value = 0;                             // coordinate there
};

// A view of the caller's memory; copies share it. The plan must outlive it.
class Workspace {
 public:
  Workspace() = default;
  // `memory`: at least plan.get_workspace_bytes(), aligned to 64; its content does not matter.
  Workspace(const Plan& plan, std::span<std::byte> memory) noexcept;

  // Sensors that nobody reads, by their numbers in the model: the step need not compute them, so that they are any
  // numbers from now on, in the motion that it logs too. Nothing else depends on it.
  void leave_unread(const Plan& plan, std::span<const int> unread) noexcept;

  // Outputs of the state at the end of the latest step() or update_outputs().
  AccelerationView accelerations;
  MultiplierView multipliers;
  std::span<const double> sensors;         // in the order of the model's sensors, each with its width
  std::span<const double> quantities;      // in the order of the model's quantities
  std::span<const double> laws;            // in the order of the model's laws
  std::span<const TableExit> table_exits;  // in the order of the model's tables

 private:
  friend WorkspaceData& get_data(const Workspace& workspace) noexcept;  // kernel/plan/evaluation.h
  WorkspaceData* data_ = nullptr;
};

}  // namespace unlatch
