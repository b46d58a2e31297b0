// Models with rigid contacts, for tests and golden hashes.
#pragma once

#include "tests/support/contact_models.h"

namespace unlatch::test {

// A rigid contact of two surfaces.
inline Contact touch_rigidly(const std::string& name, int base, int follower, double restitution = 0) {
  Contact contact = touch(name, base, follower, 0);
  contact.rigid = true;
  contact.restitution = restitution;
  return contact;
}

// Builds the ball of build_dropped_ball() on a rigid floor.
inline Model build_bouncing_ball(double height, double restitution) {
  Model model = build_dropped_ball(height);
  model.contacts = {touch_rigidly("ball on floor", 0, 1, restitution)};
  return model;
}

inline constexpr double kRodHalf = 0.5;  // m
inline constexpr double kRodTip = 0.01;  // m

// Builds a rod of 1 kg on a floor without friction, at rest on the ball at its end, `angle` above the horizontal in x
// and z.
inline Model build_falling_rod(double angle) {
  Model model;
  model.name = "rod";
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies.push_back(box("rod", 1, 1e-3, 1.0 / 12, 1.0 / 12));
  model.bodies[0].p_WB = {0, 0, kRodTip + kRodHalf * std::sin(angle)};
  model.bodies[0].q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY()));
  model.surfaces = {{"floor", kGround, {build_floor()}}, {"tip", 0, {build_sphere(kRodTip, {-kRodHalf, 0, 0})}}};
  model.contacts = {touch_rigidly("tip on floor", 0, 1)};
  add_contact_events(model);
  return model;
}

// Builds a block of 2 kg on four feet that stand on the floor.
inline Model build_rigid_feet() {
  Model model;
  model.name = "feet";
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies.push_back(box("block", 2, 0.02, 0.03, 0.04));
  model.bodies[0].p_WB = {0, 0, 0.25};
  model.surfaces = {{"floor", kGround, {build_floor()}}, {"feet", 0, {}}};
  for (const double x : {-0.25, 0.25})
    for (const double y : {-0.125, 0.125}) model.surfaces[1].shapes.push_back(build_sphere(0.125, {x, y, -0.125}));
  model.contacts = {touch_rigidly("feet on floor", 0, 1)};
  add_contact_events(model);
  return model;
}

// Builds a satellite that a push beside its centre of mass turns between rails above, below and on both sides: two feet
// at each end, each in a corner of two rails, 0.3 mm from both. Without loss; `stiffness` 0: rigid.
inline Model build_rails(double stiffness) {
  Model model;
  model.name = "rails";
  model.bodies.push_back(box("satellite", 4, 0.007, 0.042, 0.0415));
  constexpr double kRail = 0.0553, kFoot = 0.045;
  for (const Vec3& at : {Vec3{0, kRail, 0}, Vec3{0, -kRail, 0}, Vec3{0, 0, kRail}, Vec3{0, 0, -kRail}}) {
    geometry::Shape rail;
    rail.kind = geometry::ShapeKind::kBox;
    rail.from = {0.05, at.y, at.z};
    rail.size = at.y != 0 ? Vec3{0.5, 0.01, 0.12} : Vec3{0.5, 0.12, 0.01};
    model.surfaces.push_back({"rail" + std::to_string(model.surfaces.size()), kGround, {rail}});
  }
  for (const Vec3& at : {Vec3{-0.165, kFoot, kFoot}, Vec3{-0.165, -kFoot, -kFoot}, Vec3{0.165, kFoot, -kFoot},
                         Vec3{0.165, -kFoot, kFoot}}) {
    const int foot = static_cast<int>(model.surfaces.size());
    const std::string name = "foot" + std::to_string(foot - 4);
    model.surfaces.push_back({name, 0, {build_sphere(0.005, at)}});
    for (const int rail : {at.y > 0 ? 0 : 1, at.z > 0 ? 2 : 3}) {
      Contact contact = touch_rigidly(name + " on rail" + std::to_string(rail), rail, foot, 1);
      if (stiffness > 0) {
        contact.rigid = false;
        contact.restitution.reset();
        contact.stiffness = stiffness;
      }
      model.contacts.push_back(contact);
    }
  }
  Load push;
  push.name = "push";
  push.point = {-0.17, 0.0016, 0.0012};
  push.direction = {1, 0, 0};
  push.profile.value = 30;  // N
  model.loads.push_back(push);
  add_contact_events(model);
  return model;
}

// Builds a stool of four feet that falls, tilted and turning, on a table that stands on four legs of its own:
// `restitution` of feet and legs. Numbers by `draw`, from −1 to 1.
template <class Draw>
Model build_random_stool(const Draw& draw, double restitution) {
  Model model;
  model.name = "stool";
  model.gravity.uniform = {0, 0, -kGravity};
  const double mass = 1 + 0.5 * draw();
  model.bodies.push_back(box("stool", mass, 0.02 * mass, 0.025 * mass, 0.03 * mass));
  model.bodies.push_back(box("table", 5, 0.5, 0.5, 0.9));
  Body& stool = model.bodies[0];
  stool.p_WB = {0.2 * draw(), 0.2 * draw(), 1.15};
  stool.q_WB = Eigen::Quaterniond(1, 0.1 * draw(), 0.1 * draw(), draw()).normalized();
  stool.v_WB = {0.5 * draw(), 0.5 * draw(), -1 + draw()};
  stool.w_WB_B = {2 * draw(), 2 * draw(), 2 * draw()};
  model.bodies[1].p_WB = {0, 0, 0.4};
  geometry::Shape top, rail;
  top.kind = geometry::ShapeKind::kBox;
  top.size = {1.2, 1.2, 0.4};
  rail.kind = geometry::ShapeKind::kCapsule;
  rail.from = {-0.5, -0.3, 0.2};
  rail.to = {-0.2, 0.5, 0.2};
  rail.radius = 0.1;
  model.surfaces = {{"table", 1, {top, rail}}, {"feet", 0, {}}, {"floor", kGround, {build_floor()}}, {"legs", 1, {}}};
  for (const double x : {-0.2, 0.2})
    for (const double y : {-0.15, 0.15}) {
      model.surfaces[1].shapes.push_back(build_sphere(0.05, {x, y, -0.2}));
      model.surfaces[3].shapes.push_back(build_sphere(0.1, {2.5 * x, 3 * y, -0.3}));
    }
  model.contacts = {touch_rigidly("feet on table", 0, 1, restitution),
                    touch_rigidly("feet on floor", 2, 1, restitution),
                    touch_rigidly("legs on floor", 2, 3, restitution)};
  add_contact_events(model);
  return model;
}

// Builds the chain of tests/references/rigid_reference.py: two links that fall from a hinge about z, in x and y, over a
// floor that the ball at their end meets.
inline Model build_falling_chain() {
  Model model;
  model.name = "chain";
  model.gravity.uniform = {0, -kGravity, 0};
  const auto add = [&](const std::string& name, double mass, double inertia, double half, double angle, double x,
                       double y) {
    Body link = box(name, mass, inertia / 10, inertia, inertia);
    link.p_WB = {x + half * std::cos(angle), y + half * std::sin(angle), 0};
    link.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    model.bodies.push_back(link);
    Joint hinge;
    hinge.name = "hinge of " + name;
    hinge.modes = {{"hinge", kRevoluteRows}};
    hinge.base = model.bodies.size() == 1 ? kGround : 0;
    hinge.follower = static_cast<int>(model.bodies.size()) - 1;
    if (hinge.base == 0) hinge.point_base = {0.4, 0, 0};
    hinge.point_follower = {-half, 0, 0};
    model.joints.push_back(hinge);
  };
  add("first", 2, 0.15, 0.4, 0.3, 0, 0);
  add("second", 1, 0.04, 0.3, -0.2, 0.8 * std::cos(0.3), 0.8 * std::sin(0.3));
  geometry::Shape floor = build_floor();
  floor.normal = {0, 1, 0};
  floor.from = {0, -0.8, 0};
  model.surfaces = {{"floor", kGround, {floor}}, {"end", 1, {build_sphere(0.05, {0.3, 0, 0})}}};
  model.contacts = {touch_rigidly("end on floor", 0, 1, 0.2)};
  model.contacts[0].settle = 2e-3;
  add_contact_events(model);
  return model;
}

}  // namespace unlatch::test
