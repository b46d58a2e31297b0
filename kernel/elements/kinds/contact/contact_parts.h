// Parts into which closed contacts cut a step: a given number, or as many as they need.
//
// The automatic number is chosen anew at the beginning of each part, for the rest of the step, from the state alone, so
// that the longest part is taken that resolves the stiffest closed pair. Rates of a pair, as if no joint held its two
// bodies, which gives their greatest mobility m⁻¹ (constraints only lessen it):
//
//   blow      √(dF/dδ · m⁻¹) at the depth that the present depth and approach speed lead to: k δⁿ⁺¹/(n + 1) = elastic
//             energy now + ½ m v²; and the damping there, k δⁿ d m⁻¹
//   friction  μ F m⁻¹, F the force at that depth, or the present acceleration of the slip, over the slip that may be
//             left at the part's end
//
//   rigid     of a rigid contact whose friction slips: what that may change the slip by, over half of the slip; where
//             the slip begins or ends, its acceleration over the least slip that has a direction of its own
//
// A blow is resolved within 0.12 of its rate; a vibration that is a small part of the depth, less finely: what the
// method errs by is a part of the vibration (THEORY.md). Rigid contacts alone cut the step itself, into a power of two.
//
// Where the blow or the vibration would cut the step into many parts, these are of order eight instead
// (kernel/integration/eighth_order.h): with fewer and longer parts they err less.
//
// A model may ask for automatic parts that are so many times as fine (unlatch/model/contact_substeps.h).
//
// Where even kMaxAutomaticSubsteps parts do not resolve a pair, the step goes on with so many; hil's notices report it.
#pragma once

#include "kernel/elements/instant.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch {

// How contacts are integrated in a sub-step.
enum class Contacts : std::uint8_t {
  kExplicit,     // by RK4, as all else
  kEighthOrder,  // by a Runge-Kutta method of order eight, with all else (kernel/integration/eighth_order.h)
  kImplicit,     // implicit in the forces of contacts (kernel/integration/contact_stages.h)
};

// How a step goes on while contacts are closed.
struct ContactParts {
  std::int32_t count = 1;                   // parts into which the step is cut, or its rest
  Contacts contacts = Contacts::kExplicit;  // of the next one
  bool of_rest = false;                     // the parts are those of the rest of the step
};

// The most closed pairs of implicit parts, and the most bodies and auxiliary states of systems with parts of either
// method of their own, for which there is room.
inline constexpr std::size_t kMostImplicitPairs = 8, kMostImplicitBodies = 16, kMostImplicitAuxiliary = 96;

// True if parts may be implicit or of order eight: they are automatic, there is room for them, and no springs of
// joints, modes, masses that burn or rigid contacts have a method of their own.
bool may_be_implicit(const PlanData& plan) noexcept;

// Parts of the step from the present state on, at `t`, s; `ev` is its evaluation: 1 if no contact is closed. `rest`: to
// the end of the step, s.
ContactParts choose_contact_parts(const PlanData& plan, const State& state, double t, double rest,
                                  const Evaluation& ev) noexcept;

// The smallest number of parts into which a closed contact can cut a step.
inline int get_fewest_parts(const PlanData& plan) {
  return has_automatic_parts(plan.contact_substeps) ? 1 : plan.contact_substeps;
}

}  // namespace unlatch
