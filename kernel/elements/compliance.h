// Springs that a step cannot resolve: integrated implicitly, as compliant rows along their joint's edge.
//
// While one is switched on, a sub-step is ROS2 instead of RK4 (Verwer, Spee, Blom, Hundsdorfer 1999): for y' = f(y),
//   (I − γ h A) k1 = f(y),   (I − γ h A) k2 = f(y + h k1) − 2 k1,   y⁺ = y + 3/2 h k1 + 1/2 h k2,   γ = 1 − 1/√2,
// of order two for any A, L-stable for the forces that A holds. A holds these springs and the kinematics x' = v alone,
// so with e = γ h (`gamma_h`) both stages are solves of the step's own matrix with e (e k + d) added to the spring's
// pivot:
//   k1:  a1 with −e k x'_n beside the spring's force                 x' = v + e a1,                 v' = a1
//   k2:  a2 with −e k (x'_2 − 2 (x'_n + e q1)) + 2 e (e k + d) q1    x' = v_2 + e (a2 − 2 a1),      v' = a2
// q1 being the coordinate's acceleration in a1, x_2 = x_n + h (x'_n + e q1), x'_2 = x'_n + h q1, and
// y⁺ = y + h/2 (first + second). No fill, no iteration.
//
// Modes of flexible bodies are springs on their modal coordinates. A joint with such a spring is eliminated through its
// freedoms whatever its mode, since the spring acts on one of them. About an axis of a joint whose other rotations are
// free the spring acts along the gradient g of its angle (calc_angle_gradient()), for which A has the axis n: any A is
// of order two, and this one damps what it does while g is near n, as in a stiff bushing. Where the follower's axis has
// swung far, a stiff spring is unstable; hil/run/notices/implicit_audit.h reports that.
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/plan.h"

namespace unlatch {

inline constexpr double kGamma = 0.29289321881345254;  // 1 − 1/√2

enum class ImplicitStage : std::int32_t { kOff, kFirst, kSecond };
// The stage of a sub-step with implicit elements; kOff: an explicit one, or an evaluation at an instant.
struct Implicit {
  ImplicitStage stage = ImplicitStage::kOff;
  double h = 0, gamma_h = 0;  // s
};

// True if some element that is integrated implicitly is on at time t.
bool is_stiff(const PlanData& plan, const State& state, double t) noexcept;

// The first stage of a sub-step of h seconds from t: stiffnesses, dampings and what they add to their freedoms' pivots.
Implicit begin_compliance(const PlanData& plan, const State& state, double t, double h, Evaluation& ev) noexcept;
// The second stage, from the first stage's solution.
Implicit begin_second_stage(const PlanData& plan, const Implicit& first, Evaluation& ev) noexcept;

// What a spring of stiffness k and damping d, or a mode, adds to the pivot of its freedom: e (e k + d).
inline double calc_implicit_pivot(double k, double d, double gamma_h) { return gamma_h * (gamma_h * k + d); }
// Its effort beyond that of an explicit one, N or N m, in the first and in the second stage, at the rate of its
// coordinate at that stage. `first_rate`, `first_acceleration`: k1 of the coordinate and of its rate.
inline double calc_first_lead(double k, double rate, double gamma_h) { return -gamma_h * k * rate; }
inline double calc_second_lead(double k, double d, double rate, double first_rate, double first_acceleration,
                               double gamma_h) {
  return 2 * calc_implicit_pivot(k, d, gamma_h) * first_acceleration - gamma_h * k * (rate - 2 * first_rate);
}

// The same of a spring in a joint at the present stage. In the second stage `x` and `rate` become the method's values
// of the coordinate instead of those of the bodies' stage, which are off along their tangents by some h²: a large force
// where the spring is stiff.
double calc_lead(const CompliantSpring& spring, const Implicit& implicit, double& x, double& rate) noexcept;

}  // namespace unlatch
