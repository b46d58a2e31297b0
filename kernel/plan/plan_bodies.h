// Bodies of a plan that bend or burn: flexible ones with their markers, and those with a mass law.
#pragma once

#include <cstdint>

#include "kernel/math/spatial.h"
#include "kernel/plan/list_kinds.h"

namespace unlatch {

// A flexible body, see kernel/dynamics/flexible.h.
struct PlanFlexible {
  std::int32_t body, modes;
  std::int32_t first_marker, markers;  // into PlanData::markers
  std::int32_t auxiliary;              // into State::auxiliary: its modal coordinates, then their rates
  std::int32_t numbers;                // into PlanData::modal: invariants, stiffness and damping
  std::int32_t work;                   // into Evaluation::modal
  std::int32_t inboard;                // marker that it is held by, into PlanData::markers; kNone for a root
  bool implicit;                       // some mode swings faster than the step resolves
  double mass;                         // kg
  Sym3 inertia;                        // undeformed, body axes, kg m²
};
struct PlanMarker {
  std::int32_t body, flexible;
  std::int32_t numbers;  // into PlanData::modal: Φ, then Ψ, three per mode
  Vec3 position;         // undeformed, from the body's origin, body axes, m
  bool bare;             // no joint is at it
};

struct MassKnot {
  double at, mass;
  Vec3 centre;
  Sym3 inertia;
};
struct PlanVarying {
  std::int32_t body, first, count;  // of its knots
  bool by_burnt, jet_damping;
  Vec3 exit;
};

// In PlanLists.
template <template <class> class List>
struct PlanBodyLists {
  List<PlanVarying> varying;
  List<MassKnot> mass_knots;
  List<PlanFlexible> flexible;
  List<PlanMarker> markers;  // those of one flexible body together
  List<double> modal;
  List<double> initial_auxiliary;  // auxiliary states: burnt by each of `varying`, modal ones, contacts

  // Calls use(list…) with each list: that of one name of all `lists`. A new list goes here as well.
  template <class Use, class... Lists>
  static constexpr void for_each(const Use& use, Lists&... lists) {
    use(lists.varying...);
    use(lists.mass_knots...);
    use(lists.flexible...);
    use(lists.markers...);
    use(lists.modal...);
    use(lists.initial_auxiliary...);
  }
};

}  // namespace unlatch
