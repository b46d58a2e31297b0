// Models with contacts, for tests, golden hashes and benches. Exact arithmetic only: every machine starts from the same
// bits.
#pragma once

#include <cmath>
#include <string>

#include "tests/support/small_models.h"
#include "unlatch/elementary.h"

namespace unlatch::test {

inline constexpr double kGravity = 9.81;     // m/s²
inline constexpr double kBallRadius = 0.25;  // m

inline geometry::Shape build_sphere(double radius, const Vec3& centre = {0, 0, 0}) {
  geometry::Shape shape;
  shape.from = centre;
  shape.radius = radius;
  return shape;
}

inline geometry::Shape build_floor() {
  geometry::Shape shape;
  shape.kind = geometry::ShapeKind::kHalfSpace;
  shape.normal = {0, 0, 1};
  return shape;
}

inline Contact touch(const std::string& name, int base, int follower, double stiffness) {
  Contact contact;
  contact.name = name;
  contact.base = base;
  contact.follower = follower;
  contact.stiffness = stiffness;
  return contact;
}

// Builds a ball of 1 kg at `height` above the floor.
inline Model build_dropped_ball(double height) {
  Model model;
  model.name = "ball";
  model.gravity.uniform = {0, 0, -kGravity};
  const double J = 0.4 * kBallRadius * kBallRadius;
  model.bodies.push_back(box("ball", 1, J, J, J));
  model.bodies[0].p_WB = {0, 0, kBallRadius + height};
  model.surfaces = {{"floor", kGround, {build_floor()}}, {"ball", 0, {build_sphere(kBallRadius)}}};
  model.contacts = {touch("ball on floor", 0, 1, 1e5)};
  add_contact_events(model);
  return model;
}

// Builds the same ball at rest on the floor, where the spring bears its weight.
inline Model build_resting_ball(double stiffness) {
  Model model = build_dropped_ball(-kGravity / stiffness);
  model.contacts[0].stiffness = stiffness;
  return model;
}

inline constexpr double kPassingRadius = 0.006;  // m
inline constexpr double kPassingSpeed = 2;       // m/s

// Builds a ball of 6 mm that passes a rail along z at the origin, `depth` closer than a touch, from `start` before it.
// The contact is so soft that the ball moves in a straight line: it touches and lifts at −/+ calc_half_chord() beside
// the rail.
inline Model build_passing_ball(double rail_radius, double depth, double start) {
  Model model;
  model.name = "passing";
  model.bodies.push_back(box("ball", 1, 1e-5, 1e-5, 1e-5));
  model.bodies[0].p_WB = {-start, kPassingRadius + rail_radius - depth, 0};
  model.bodies[0].v_WB = {kPassingSpeed, 0, 0};
  geometry::Shape rail = build_sphere(rail_radius, {0, 0, -0.5});
  rail.kind = geometry::ShapeKind::kCapsule;
  rail.to = {0, 0, 0.5};
  model.surfaces = {{"rail", kGround, {rail}}, {"ball", 0, {build_sphere(kPassingRadius)}}};
  model.contacts = {touch("ball on rail", 0, 1, 1e-6)};
  add_contact_events(model);
  return model;
}
inline double calc_half_chord(double rail_radius, double depth) {
  const double sum = kPassingRadius + rail_radius;
  return std::sqrt(depth * (2 * sum - depth));
}

// Builds a block of 2 kg on four feet, at rest on the floor z = 0; damped.
inline Model build_block_on_feet() {
  Model model;
  model.name = "block";
  model.gravity.uniform = {0, 0, -kGravity};
  model.bodies.push_back(box("block", 2, 0.02, 0.02, 0.03));
  model.bodies[0].p_WB = {0, 0, 0.0625};
  Surface feet{"feet", 0, {}};
  for (const double x : {-0.125, 0.125})
    for (const double y : {-0.125, 0.125}) feet.shapes.push_back(build_sphere(0.03125, {x, y, -0.03125}));
  model.surfaces = {{"floor", kGround, {build_floor()}}, feet};
  model.contacts = {touch("feet on floor", 0, 1, 2e4)};
  model.contacts[0].damping = 50;
  add_contact_events(model);
  return model;
}

// Builds the same block where it bears its weight, on an incline on which it sticks: the slip decays at some 1e6/s.
inline Model build_sticking_block() {
  Model model = build_block_on_feet();
  model.name = "sticking";
  model.gravity.uniform = {0.125 * kGravity, 0, -kGravity};
  model.bodies[0].p_WB.z() -= kGravity / 4e4;
  model.contacts[0].friction = 0.625;
  model.contacts[0].slip_speed = 1e-5;
  return model;
}

// Builds two rotating balls that meet off their line, with friction and damping.
inline Model build_spinning_pair() {
  Model model;
  model.name = "pair";
  model.bodies = {box("a", 1, 0.025, 0.025, 0.025), box("b", 2, 0.05, 0.05, 0.05)};
  model.bodies[0].v_WB = {2, 0, 0.25};
  model.bodies[0].w_WB_B = {1, 8, -3};
  model.bodies[1].p_WB = {0.6, 0.125, 0.0625};
  model.bodies[1].w_WB_B = {-4, 2, 5};
  model.surfaces = {{"a", 0, {build_sphere(0.25)}}, {"b", 1, {build_sphere(0.25)}}};
  model.contacts = {touch("a on b", 0, 1, 1e4)};
  model.contacts[0].damping = 0.25;
  model.contacts[0].friction = 0.5;
  model.contacts[0].slip_speed = 0.0625;
  add_contact_events(model);
  return model;
}

// Builds a capsule of 2 kg that bounces in a tube, as in tests/references/tube_reference.py.
inline Model build_capsule_in_tube() {
  Model model;
  model.name = "tube";
  model.bodies.push_back(box("capsule", 2, 0.0625, 0.0625, 0.03125));
  model.bodies[0].p_WB = {0.03125, 0, 0};
  model.bodies[0].q_WB = Attitude(elementary::cos(0.125), 0, elementary::sin(0.125), 0);  // 0.25 rad about y
  model.bodies[0].v_WB = {1.5, 0, 1};
  model.bodies[0].w_WB_B = {0, 0.375, 0};
  geometry::Shape capsule = build_sphere(0.125, {0, 0, -0.25}), tube;
  capsule.kind = geometry::ShapeKind::kCapsule;
  capsule.to = {0, 0, 0.25};
  tube.kind = geometry::ShapeKind::kHollow;
  tube.from = {0, 0, -4};
  tube.to = {0, 0, 12};
  tube.profile = {{0, 0.5}, {16, 0.5}};
  model.surfaces = {{"tube", kGround, {tube}}, {"capsule", 0, {capsule}}};
  model.contacts = {touch("capsule in tube", 0, 1, 5e4)};
  model.contacts[0].damping = 0.125;
  model.contacts[0].friction = 0.25;
  model.contacts[0].slip_speed = 0.125;
  model.contact_substeps = 16;
  add_contact_events(model);
  return model;
}

// Builds sixteen pairs of shapes, four of them closed: capsules at rest on the floor beside each other, a cone and a
// box that fall towards it.
inline Model build_sixteen_pairs() {
  Model model;
  model.name = "pairs";
  model.gravity.uniform = {0, 0, -kGravity};
  model.surfaces.push_back({"floor", kGround, {build_floor()}});
  constexpr double kStiffness = 2e4;
  const auto add = [&](const std::string& name, const Eigen::Vector3d& place, const geometry::Shape& shape) {
    model.bodies.push_back(box(name, 1, 0.01, 0.0125, 0.015));
    model.bodies.back().p_WB = place;
    model.surfaces.push_back({name, static_cast<int>(model.bodies.size()) - 1, {shape}});
  };
  const auto join = [&](int base, int follower) {
    Contact contact = touch("contact" + std::to_string(model.contacts.size()), base, follower, kStiffness);
    contact.damping = 0.5;
    contact.friction = 0.25;
    contact.slip_speed = 0.0625;
    model.contacts.push_back(contact);
  };
  geometry::Shape capsule = build_sphere(0.0625, {0, -0.25, 0}), cone = build_sphere(0.25, {0, 0, 0}), block;
  capsule.kind = geometry::ShapeKind::kCapsule;
  capsule.to = {0, 0.25, 0};
  cone.kind = geometry::ShapeKind::kCone;
  cone.to = {0, 0, 0.5};
  block.kind = geometry::ShapeKind::kBox;
  block.size = {0.25, 0.25, 0.25};
  for (int i = 0; i < 4; ++i)
    add("capsule" + std::to_string(i), {0.1875 * i, 0, 0.0625 - kGravity / kStiffness}, capsule);
  add("cone", {0.25, 0, 0.25}, cone);
  add("block", {0.25, 0.75, 0.25}, block);
  for (int a = 1; a <= 4; ++a) {
    join(0, a);
    for (int b = a + 1; b <= 5; ++b) join(a, b);
  }
  join(0, 5);
  join(0, 6);
  return model;
}

// Builds `bodies` balls, capsules, boxes and hulls that fall onto the floor and each other; the first also in a tube.
inline Model build_heap(int bodies) {
  Model model;
  model.name = "heap";
  model.gravity.uniform = {0, 0, -kGravity};
  model.surfaces.push_back({"floor", kGround, {build_floor()}});
  for (int b = 0; b < bodies; ++b) {
    const std::string name = "body" + std::to_string(b);
    Body body = box(name, 1, 0.01, 0.0125, 0.015);
    body.p_WB = {0.0625 * b, 0.03125 * (b % 3), 0.25 + 0.25 * b};
    body.w_WB_B = {0.5, -0.25 * b, 0.125};
    model.bodies.push_back(body);
    geometry::Shape shape = build_sphere(0.125);
    switch (b % 4) {
      case 1:
        shape.kind = geometry::ShapeKind::kCapsule;
        shape.from = {-0.125, 0, 0};
        shape.to = {0.125, 0, 0};
        shape.radius = 0.0625;
        break;
      case 2:
        shape.kind = geometry::ShapeKind::kBox;
        shape.size = {0.25, 0.1875, 0.125};
        break;
      case 3:
        shape.kind = geometry::ShapeKind::kHull;
        shape.points = {{0.125, 0, 0}, {-0.125, 0, 0}, {0, 0.125, 0}, {0, -0.125, 0}, {0, 0, 0.125}, {0, 0, -0.125}};
        break;
      default:
        break;
    }
    model.surfaces.push_back({name, b, {shape}});
  }
  geometry::Shape tube;
  tube.kind = geometry::ShapeKind::kHollow;
  tube.to = {0, 0, 0.5};
  tube.profile = {{0, 0.15625}, {0.5, 0.1875}};
  model.surfaces.push_back({"tube", kGround, {tube}});
  const auto join = [&model](int base, int follower) {
    Contact contact = touch(model.surfaces[static_cast<std::size_t>(follower)].name + " on " +
                                model.surfaces[static_cast<std::size_t>(base)].name,
                            base, follower, 1e4);
    contact.damping = 0.5;
    contact.friction = 0.25;
    if ((base + follower) % 2 == 1) {
      contact.exponent = 1.5;
      contact.stiffness = 1e5;
    }
    model.contacts.push_back(contact);
  };
  for (int b = 1; b <= bodies; ++b) {
    join(0, b);
    if (b > 1) join(b - 1, b);
  }
  join(bodies + 1, 1);
  model.contact_substeps = 4;
  add_contact_events(model);
  Sensor sensor;
  sensor.name = "gap";
  sensor.kind = Sensor::Kind::kDistance;
  sensor.subject = 1;
  sensor.other = 2;
  model.sensors.push_back(sensor);
  return model;
}

}  // namespace unlatch::test
