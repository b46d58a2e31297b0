// Elements, and what they read: coordinates, profiles, shapes, the air.
#include <algorithm>
#include <cmath>

#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/images/plan_check.h"
#include "unlatch/contacts.h"

namespace unlatch {

void PlanCheck::check_coordinates() {
  std::int32_t rotations = 0;
  for (const PlanCoordinate& c : plan_.coordinates) {
    require_index(c.joint, plan_.joints.size());
    require_index(c.row, kRows);
    rotations += c.row >= kRotX ? 1 : 0;
  }
  require(rotations == plan_.rotation_count);
}

void PlanCheck::check_loads() {
  for (const PlanProfile& profile : plan_.profiles) {
    require_kind(profile.kind, Profile::Kind::kLaw);
    if (!good_) return;
    if (profile.kind == Profile::Kind::kHarmonic) require_range(profile.first, profile.count, plan_.harmonics.size());
    if (profile.kind != Profile::Kind::kTable) continue;
    require_range(profile.first, profile.count, plan_.knots.size());
    require(profile.count >= 2 || (profile.count == 1 && good_ && std::isfinite(plan_.knots[at(profile.first)].time)));
  }
  for (const PlanLoad& load : plan_.loads) {
    require_flag(load.world);
    require_flag(load.apart);
    require_body(load.body);
    require_element(load.element);
    require_index(load.profile, plan_.profiles.size());
    require_channel(load.channel);
    require_optional(load.varying, plan_.varying.size());
    require(!(load.consumption != 0) || load.varying != kNone);
    require_optional(load.law, plan_.laws.list.size());
    if (!good_ || load.apart) continue;
    const std::int32_t body = plan_.places[at(load.body)].body;
    const auto after = std::upper_bound(plan_.eights.begin(), plan_.eights.end(), body,
                                        [](std::int32_t b, const BodyEight& other) { return b < other.body; });
    require(std::prev(after)->loaded);
  }
  for (const std::int32_t i : plan_.external_loads) require_index(i, plan_.loads.size());
  for (const std::int32_t i : plan_.laws.loads) {
    require_index(i, plan_.loads.size());
    if (good_) require(plan_.loads[at(i)].law != kNone);
  }
}

void PlanCheck::check_springs() {
  for (const PlanPointSpring& own : plan_.point_springs) {
    require_body_or_ground(own.base);
    require_body(own.follower);
    require_element(own.element);
    require_flag(own.push_only);
  }
  for (const PlanJointSpring& own : plan_.joint_springs) {
    require_index(own.joint, plan_.joints.size());
    require_index(own.axis, kRows);
    require_element(own.element);
    require_index(own.coordinate, plan_.coordinates.size());
    require_optional(own.compliant, plan_.compliant.size());
  }
  for (const PlanCompliant& own : plan_.compliant) {
    require_index(own.spring, plan_.joint_springs.size());
    require_index(own.pivot.at, at(plan_.block_numbers));
    require_index(own.acceleration.at, at(plan_.block_numbers));
  }
  for (const PlanPlaneTorsion& own : plan_.plane_torsions) {
    require_body_or_ground(own.base);
    require_body(own.follower);
    require_element(own.element);
  }
  for (const PlanFriction& own : plan_.frictions) {
    require_index(own.joint, plan_.joints.size());
    require_index(own.axis, kRows);
    require_element(own.element);
    require_index(own.coordinate, plan_.coordinates.size());
  }
}

void PlanCheck::check_shapes() {
  using geometry::ShapeKind;
  for (const geometry::ShapeNumbers& part : plan_.shape_parts) {
    require_flag(part.half);
    require_kind(part.kind, ShapeKind::kHollow);
    if (!good_) return;
    require(part.kind != ShapeKind::kCylinder && part.kind != ShapeKind::kCone);  // are frustums
    if (part.kind == ShapeKind::kHull) {
      require_range(part.first, part.count, plan_.hull_points.size());
      require(part.count >= 4 && part.count <= geometry::kMaxHullPoints);
    } else if (part.kind == ShapeKind::kHollow) {
      require_range(part.first, part.count, plan_.profile_points.size());
      require(part.count >= 2 && part.count <= geometry::kMaxProfilePoints);
    }
  }
  for (const PlanShapes& own : plan_.shapes) {
    require_body_or_ground(own.body);
    require_range(own.first, own.count, plan_.shape_parts.size());
    require(own.count >= 1);
  }
  constexpr std::int64_t kTotals = sizeof(ContactTotals) / sizeof(double);
  for (const PlanContact& own : plan_.contacts) {
    require_flag(own.hertzian);
    require_flag(own.rigid);
    require_index(own.base, plan_.shapes.size());
    require_index(own.follower, plan_.shapes.size());
    require_element(own.element);
    require_range(own.first_pair, own.pairs, plan_.contact_pairs.size());
    require_range(own.auxiliary, kTotals, plan_.initial_auxiliary.size());
  }
  for (const ContactPair& own : plan_.contact_pairs) {
    require_flag(own.closed);
    require_index(own.contact, plan_.contacts.size());
    if (!good_) return;
    const PlanContact& contact = plan_.contacts[at(own.contact)];
    require_index(own.base_shape, at(plan_.shapes[at(contact.base)].count));
    require_index(own.follower_shape, at(plan_.shapes[at(contact.follower)].count));
  }
  check_rigid_contacts();
  // The pairs of each contact are its own.
  for (std::size_t c = 0; c < plan_.contacts.size() && good_; ++c)
    for (std::int32_t i = 0; i < plan_.contacts[c].pairs; ++i)
      require(plan_.contact_pairs[at(plan_.contacts[c].first_pair + i)].contact == static_cast<std::int32_t>(c));
}

// Each pair can have a row, and there is room for the rows of all.
void PlanCheck::check_rigid_contacts() {
  std::int64_t pairs = 0;
  for (const ContactPair& own : plan_.contact_pairs) {
    if (!good_ || !plan_.contacts[at(own.contact)].rigid) continue;
    const PlanContact& contact = plan_.contacts[at(own.contact)];
    const auto get_kind = [&](std::int32_t shapes, std::int32_t shape) {
      return plan_.shape_parts[at(plan_.shapes[at(shapes)].first + shape)].kind;
    };
    require(has_rigid_row(get_kind(contact.base, own.base_shape), get_kind(contact.follower, own.follower_shape)));
    ++pairs;
  }
  require(plan_.rigid_pairs == pairs && count_rigid_rows(plan_) <= kMostRigidRows);
}

void PlanCheck::check_one_sided() {
  for (std::size_t i = 0; i < plan_.one_sided.size(); ++i) {
    const PlanOneSided& own = plan_.one_sided[i];
    require_flag(own.guided);
    require(own.number == static_cast<std::int32_t>(i));
    require_element(own.element);
    require_optional(own.joint, plan_.joints.size());
    require_body_or_ground(own.base);
    require_body(own.follower);
    require_kind(own.law.kind, OneSided::Law::kGas);
    require_optional(own.drum, plan_.drums.size());
    if (own.joint != kNone) {
      require_index(own.axis, kRows);
      require_index(own.coordinate, plan_.coordinates.size());
    }
    for (const std::size_t size : {plan_.travels.size(), plan_.travel_forces.size()})
      require_range(own.first, own.count, size);
    if (good_) require(own.law.kind != OneSided::Law::kTable || own.count >= 2);
  }
}

void PlanCheck::check_air() {
  // Above its layers the standard atmosphere is a table too.
  if (plan_.environment.has_air) require(plan_.environment.exists && plan_.air_knots.size() >= 2);
  for (const PlanAeroTerm& term : plan_.aero_terms) {
    require_kind(term.of, AeroTerm::Of::kDrag);
    require_optional(term.rate, 3);
    require_optional(term.law, plan_.laws.list.size());
  }
  for (std::size_t i = 0; i < plan_.air_corners.size(); ++i)
    require(i == 0 || plan_.air_corners[i] > plan_.air_corners[i - 1]);
  for (std::size_t i = 0; i < plan_.aerodynamics.size(); ++i) {
    const PlanAerodynamics& own = plan_.aerodynamics[i];
    require(plan_.environment.has_air && own.number == static_cast<std::int32_t>(i));
    require_body(own.body);
    require_element(own.element);
    require_range(own.first, own.count, plan_.aero_terms.size());
  }
}

}  // namespace unlatch
