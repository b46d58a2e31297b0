// The kinds of force elements, in the order of the numbering that a model's elements share. A new kind goes to the end:
// it moves no number of the others, and no sum of forces changes.
//
// A kind is a struct of static members; README.md of this folder says what each is for.
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

#include "kernel/elements/kinds/aerodynamics.h"
#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/elements/kinds/friction.h"
#include "kernel/elements/kinds/joint_spring.h"
#include "kernel/elements/kinds/load.h"
#include "kernel/elements/kinds/one_sided/one_sided.h"
#include "kernel/elements/kinds/plane_torsion.h"
#include "kernel/elements/kinds/point_spring.h"

namespace unlatch {

using ElementKinds = std::tuple<LoadKind, PointSpringKind, JointSpringKind, PlaneTorsionKind, ContactKind, OneSidedKind,
                                FrictionKind, AerodynamicsKind>;
inline constexpr std::size_t kElementKinds = std::tuple_size_v<ElementKinds>;

// Calls use(kind) with an object of each kind, in order; kinds have no data, only their type counts.
template <class Use>
UNLATCH_INLINE void for_each_kind(const Use& use) {
  [&]<std::size_t... i>(std::index_sequence<i...>) { (use(std::tuple_element_t<i, ElementKinds>{}), ...); }
  (std::make_index_sequence<kElementKinds>{});
}

// The effort of an element is one force or torque between two bodies. Loads and contacts are not of that form.
template <class Kind>
concept HasEffort = requires {
  &Kind::template calc<StageMotion>;
};
// It is a spring, for frequencies.
template <class Kind>
concept HasSpring = requires {
  &Kind::get_spring;
};

}  // namespace unlatch
