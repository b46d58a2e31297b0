# Sources of stepping: no exceptions, no run-time types, no heap. For the library of this machine (CMakeLists.txt) and for
# targets without operating system (targets).
set(UNLATCH_STEPPING_SOURCES
  dispatch/kernels.cc dispatch/baseline.cc
  dynamics/balance.cc dynamics/energy.cc dynamics/flexible.cc dynamics/forces.cc dynamics/planet_forces.cc dynamics/varying.cc
  elements/compliance.cc elements/readings.cc
  elements/kinds/friction.cc elements/kinds/load.cc elements/kinds/contact/contact.cc elements/kinds/contact/contact_parts.cc elements/kinds/contact/rigid_row.cc
  elements/kinds/one_sided/cord_path.cc elements/kinds/one_sided/one_sided.cc
  environment/air.cc environment/environment.cc environment/field.cc environment/planet.cc
  events/cone_impulses.cc events/corner_marks.cc events/corners.cc events/event_search.cc events/events.cc events/guards.cc events/impulses.cc events/rigid_friction.cc events/rigid_pairs.cc
  geometry/closest.cc geometry/convex.cc geometry/core.cc geometry/distance.cc geometry/gjk.cc geometry/groups.cc geometry/middle.cc
  geometry/penetration.cc geometry/strips.cc geometry/wall.cc
  images/check_blocks.cc images/check_elements.cc images/check_events.cc images/check_laws.cc images/check_loops.cc
  images/open_plan.cc images/plan_check.cc
  integration/contact_stages.cc integration/eighth_order.cc integration/integrator.cc integration/load_state.cc integration/rigid_rows.cc integration/run.cc
  joints/coordinates.cc joints/kinematics.cc joints/residuals.cc
  laws/laws.cc laws/tables.cc
  math/elementary.cc
  plan/evaluation.cc plan/plan_image.cc plan/state.cc
  quantities/table.cc
  simd/instruction_set.cc
  solver/flexible_solver.cc solver/loops/loop_rows.cc solver/loops/redundant_rows.cc
  step/bundle.cc step/motion.cc step/step.cc)
