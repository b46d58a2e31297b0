// PlanData: the model compiled for one step size. Numbers in flat arrays in the order in which the step reads them,
// without names and Eigen types. Never changes; any number of threads may step with one plan.
//
// One elimination order serves all modes of the joints: it is that of the full tree, and a mode only decides which of
// its joint's six rows hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernel/environment/environment.h"
#include "kernel/math/index.h"
#include "kernel/plan/plan_bodies.h"
#include "kernel/plan/plan_elements.h"
#include "kernel/plan/plan_events.h"
#include "kernel/plan/plan_loops.h"
#include "kernel/plan/plan_tree.h"
#include "unlatch/plan.h"

namespace unlatch {

// Part of a step: times nearer than this are one instant.
inline constexpr double kSameInstant = 1e-9;

// Numbers of a plan.
struct PlanNumbers {
  PlanOptions options;
  InstructionSet instruction_set = InstructionSet::kScalar;  // chosen for this processor
  std::uint64_t hash = 0;  // of the model and its options: two plans with one hash step alike
  double get_time(std::int64_t tick) const { return static_cast<double>(tick) * options.dt; }  // s
  double get_slack() const { return kSameInstant * options.dt; }  // s: times nearer than this are one instant

  // loops
  std::int32_t loop_rows = 0, loop_columns = 0;  // that the loops' joints hold at most; the same, padded for packs
  std::int32_t loop_load_rows = 0;               // of Evaluation::loop_loads
  std::int32_t loop_modal_rows = 0;              // of these, the first, of modal coordinates
  std::int32_t ring_rows = 0;                    // that PlanLists::ring_joints hold at most
  std::int32_t first_at_ground = 0;              // of PlanLists::closures: it and the later ones close there
  std::int32_t cluster_blocks = 0;               // of Evaluation::cluster_matrix
  std::int32_t cluster_numbers = 0;              // of Evaluation::cluster_columns

  // blocks, bodies that bend or burn
  std::int32_t block_numbers = 0;  // size of Evaluation::blocks
  std::int32_t modal_work = 0;     // size of Evaluation::modal
  bool rigid = true;               // no body bends or changes its mass: the lists of these are empty
  bool plain = true;  // likewise, and there is no planet: init_forces() has all that acts on bodies by themselves

  // elements
  GravityField gravity;
  PlanEnvironment environment;
  std::int32_t driven_coordinates = 0;  // of PlanLists::coordinates, the first, that every stage needs for springs
  std::int32_t rotation_count = 0;      // rotations among them all
  bool commanded_loads = false;         // a command decides the size of some load, or some law
  std::int32_t contact_substeps = 1;    // kAutomaticSubsteps, or a number
  bool pair_forces = false;             // there is an element other than loads
  bool solved_once = true;              // no laws, joint friction or rigid contacts: one solution has all forces
  std::int32_t rigid_pairs = 0;         // of PlanLists::contact_pairs, those of rigid contacts
  bool time_corners = false;            // forces may have some whose time is known: kernel/events/corners.h
  bool place_corners = false;           // likewise some at places that laws, travels or altitudes pass
  bool sought_corners = false;          // likewise some that a sub-step is searched for, or closed pairs have

  PlanLawNumbers law_numbers;

  // events and sensors
  bool commanded_events = false;    // a command decides some guard, itself or through the reactions
  std::int32_t quantity_count = 0;  // of PlanLists::quantities, the model's
  std::int32_t sensor_count = 0;    // values, all sensors' components counted
  std::int32_t signal_count = 0;
  std::int32_t channel_count = 0;
  std::int32_t guard_depth = 0;  // values that evaluating the deepest guard keeps at once
};

// Lists of a plan, in the one order in which images hold them.
template <template <class> class List>
struct PlanLists : PlanTreeLists<List>,
                   PlanLoopLists<List>,
                   PlanBlockLists<List>,
                   PlanBodyLists<List>,
                   PlanElementLists<List>,
                   PlanEventLists<List> {};

// A plan to step with. Its lists lie in an image (plan_image.h), which outlives it.
struct PlanData : PlanNumbers, PlanLists<FixedList> {
  std::span<const std::byte> image;
};

// A plan while it is compiled.
struct PlanDraft : PlanNumbers, PlanLists<GrowingList> {};

// Rows of rigid contacts: one for each pair of shapes, two more where it has friction.
inline std::int32_t count_rigid_rows(const PlanData& plan) {
  std::int32_t rows = plan.rigid_pairs;
  for (const PlanContact& contact : plan.contacts)
    if (contact.rigid && contact.friction > 0) rows += 2 * contact.pairs;
  return rows;
}
inline bool has_rigid_friction(const PlanData& plan) {
  return plan.rigid_pairs > 0 && count_rigid_rows(plan) > plan.rigid_pairs;
}

// Calls use(one-sided force, its travels) with each whose force is a table over its travel: its knots are corners.
void for_each_travel_corner(const PlanData& plan, const auto& use) {
  if (plan.travels.empty()) return;
  for (const PlanOneSided& own : plan.one_sided)
    if (own.count > 0) use(own, std::span<const double>(plan.travels).subspan(at(own.first), at(own.count)));
}

inline const PlanData& get_data(const Plan& plan) noexcept { return *plan.data_; }

}  // namespace unlatch
