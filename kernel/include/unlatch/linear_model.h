// Linear model about a state, for the design of controllers: the free coordinates of the present modes, their speeds,
// and how both change with small deviations and with commands.
//
// With q the deviations of the free coordinates from a motion of the system and u those of their speeds, x = (q, u):
//
//   dx/dt = A x + B c,    y = C x + D c,    c: deviations of the channels' values
//
// Modes, switches, what has burnt and what is wound on drums stay as they are. About a state at rest q is what its name
// says. About a moving one, q and u are deviations from that motion at the same time; a body's attitude deviation is
// the small rotation from the motion's attitude, in body axes, so that dq/dt = u − w × q with the motion's w.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "unlatch/plan.h"
#include "unlatch/state.h"

namespace unlatch {

// One free coordinate.
struct LinearCoordinate {
  // Kind: number of `axis`, unit of q.
  enum class Kind {
    kPosition,  // of body `subject`'s origin along axis 0, 1, 2 of W, m
    kAttitude,  // rotation of body `subject` about its own axis 0, 1, 2, rad
    kJoint,     // of joint `subject` along or about its Row `axis`, m or rad
    kModal,     // modal coordinate number `axis` of flexible body `subject`, as the body's modes are scaled
  };
  Kind kind = Kind::kPosition;  // which coordinate of which list
  int subject = 0;              // index of the body or joint in the model
  int axis = 0;                 // see Kind
};

// Matrices, their errors, and what their coordinates are; f free coordinates.
struct LinearModel {
  std::vector<LinearCoordinate> coordinates;  // f of them
  Eigen::VectorXd accelerations;              // of the free coordinates at the state, f: all zero at an equilibrium
  Eigen::MatrixXd A, B, C, D;                 // 2f × 2f, 2f × channels, outputs × 2f, outputs × channels
  // Estimated errors of the entries, by differences with two widths: same shapes.
  Eigen::MatrixXd A_error, B_error, C_error, D_error;
  std::vector<int> corners;  // columns of (A B) in which forces have a corner at the state: a stop that touches, a
                             // cord that gets taut. The column is the mean of both sides.
};

// Outputs of a linear model, of what update_outputs() leaves in a workspace.
struct LinearOutputs {
  std::vector<int> sensors;     // into Workspace::sensors
  std::vector<int> quantities;  // into Workspace::quantities
};

// The linear model about `state`, y: the sensors, then the quantities. Free coordinates are chosen in this order, each
// where those before do not decide it: freedoms of joints in the model's order, bodies' positions and attitudes, modal
// coordinates. Derivatives by positions and speeds are central differences, extrapolated once, on the manifold of the
// rows that hold: the directions are those of the solver's own projection. `commands`: one per channel. Empty if a
// pivot vanishes at the state or near it. O(n f) time, O((n + f)²) memory; allocates.
std::optional<LinearModel> calc_linear_model(const Plan& plan, const State& state, std::span<const double> commands,
                                             const LinearOutputs& outputs);

}  // namespace unlatch
