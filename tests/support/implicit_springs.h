// Oracles for springs that are integrated implicitly: ROS2 (Verwer, Spee, Blom, Hundsdorfer 1999) in dense form,
//   (I − γ h A) k1 = f(y),  (I − γ h A) k2 = f(y + h k1) − 2 k1,  y⁺ = y + 3/2 h k1 + 1/2 h k2,   γ = 1 − 1/√2,
// of order two for any A and L-stable for A = ∂f/∂y; and two systems for it, each with its model for the kernel: a
// chain of masses on springs (linear, with its exact solution) and a pendulum with a spring in its hinge (nonlinear; A
// contains the spring alone). They use nothing of the kernel but the Model.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::test {

using Rate = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;  // y' = f(y)
Eigen::VectorXd step_ros2(const Rate& f, const Eigen::MatrixXd& A, const Eigen::VectorXd& y, double h);

// Masses in a row, each on a spring and damper to the one before, the first to the ground.
struct SpringChain {
  std::vector<double> masses, stiffnesses, dampings;  // kg, N/m, N s/m
  std::vector<double> stretches, speeds;              // stretch and rate of each spring at the start, m, m/s
};
// State y = (stretches, their rates), in the order of the joints; y' = A y.
Eigen::VectorXd get_start(const SpringChain& chain);
Eigen::MatrixXd build_jacobian(const SpringChain& chain);
Eigen::VectorXd calc_exact(const SpringChain& chain, double t);  // exp(A t) y
Eigen::VectorXd run_ros2(const SpringChain& chain, double h, int steps);
double calc_energy(const SpringChain& chain, const Eigen::VectorXd& y);  // J
// Model of prismatic joints along their z, one joint spring on each; joint k is spring k.
Model build_model(const SpringChain& chain);

// A bar that hangs from a hinge in the ground, with a spring and damper about it.
struct SpringPendulum {
  double mass = 1, arm = 0.5, inertia = 0.1;  // kg; hinge to centre of mass, m; about the centre of mass, kg m²
  double stiffness = 0, damping = 0;          // N m/rad, N m s/rad
  double gravity = 9.81;                      // m/s²; pulls towards the angle −π/2, the spring towards 0
  double angle = 0, speed = 0;                // initial values, rad, rad/s
};
// Rate of y = (angle, rate).
Eigen::VectorXd calc_rate(const SpringPendulum& pendulum, const Eigen::VectorXd& y);
Eigen::MatrixXd build_spring_jacobian(const SpringPendulum& pendulum);
Eigen::VectorXd run_ros2(const SpringPendulum& pendulum, double h, int steps);
Eigen::VectorXd calc_accurate(const SpringPendulum& pendulum, double t);       // RK4 in long double, small steps
double calc_energy(const SpringPendulum& pendulum, const Eigen::VectorXd& y);  // J
Model build_model(const SpringPendulum& pendulum);                             // joint 0, joint spring 0

}  // namespace unlatch::test
