#include "tests/support/random_elements.h"

#include <algorithm>
#include <bit>
#include <string>

#include "tests/support/modal_model.h"
#include "tests/support/random_model.h"
#include "unlatch/quantities.h"

namespace unlatch::test {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

class Adder {
 public:
  Adder(Model& model, Random& random) : model_(model), random_(random) {}

  void add_loads() {
    for (int i = 0; i < 2; ++i) model_.channels.push_back({.name = "c" + std::to_string(i), .initial = 0.5});
    const int count = draw_count(12);
    for (int i = 0; i < count; ++i) {
      Load load;
      load.name = "load" + std::to_string(i);
      load.body = draw_body();
      load.kind = random_.chance(0.3) ? Load::Kind::kTorque : Load::Kind::kForce;
      load.frame = random_.chance(0.3) ? Load::Frame::kWorld : Load::Frame::kBody;
      load.point = draw_vector(0.3);
      load.direction = draw_vector(1);
      load.profile = draw_profile();
      if (random_.chance(0.3)) load.channel = random_.below(2);
      model_.loads.push_back(load);
    }
  }

  void add_springs() {
    const int points = draw_count(5), planes = draw_count(3);
    for (int i = 0; i < points; ++i) {
      PointSpring spring;
      spring.name = "spring" + std::to_string(i);
      draw_pair(spring.base, spring.follower);
      spring.point_base = draw_vector(0.5);
      spring.point_follower = draw_vector(0.5);
      spring.stiffness = 2;
      spring.damping = 0.1;
      spring.free_length = 1;
      spring.push_only = random_.chance(0.3);
      model_.point_springs.push_back(spring);
    }
    for (int i = 0; i < planes; ++i) {
      PlaneTorsion torsion;
      torsion.name = "torsion" + std::to_string(i);
      draw_pair(torsion.base, torsion.follower);
      torsion.stiffness = 0.2;
      torsion.damping = 0.02;
      model_.plane_torsions.push_back(torsion);
    }
    add_joint_springs();
  }

  void add_one_sided() {
    const int count = draw_count(5);
    for (int i = 0; i < count; ++i) {
      OneSided own;
      own.name = "pusher" + std::to_string(i);
      own.kind = random_.chance(0.5) ? OneSided::Kind::kPusher : OneSided::Kind::kStop;
      draw_pair(own.base, own.follower);
      own.point_base = draw_vector(0.5);
      own.point_follower = draw_vector(0.5);
      own.stroke = own.kind == OneSided::Kind::kPusher ? 0.4 : 0;
      own.stiffness = 1;
      own.preload = own.kind == OneSided::Kind::kPusher ? 0.5 : 0;
      own.damping = 0.05;
      own.friction = random_.chance(0.5) ? 0.01 : 0;
      own.friction_speed = 0.1;
      if (own.kind == OneSided::Kind::kStop) own.limit = random_.uniform(0.5, 2);
      model_.one_sided.push_back(own);
    }
  }

  void add_contacts(bool convex) {
    const int count = std::min(draw_count(4), static_cast<int>(model_.bodies.size()));
    size_ = random_.chance(0.4) ? 20 : 1;  // large shapes lie in each other: all their pairs are closed
    model_.surfaces.push_back({"floor", kGround, {build_shape(geometry::ShapeKind::kHalfSpace)}});
    for (int i = 0; i < count; ++i) {
      Surface surface{"surface" + std::to_string(i), i, {}};
      const int shapes = 1 + random_.below(3);
      for (int k = 0; k < shapes; ++k) surface.shapes.push_back(build_shape(draw_kind(convex)));
      model_.surfaces.push_back(surface);
      Contact contact;
      contact.name = "contact" + std::to_string(i);
      contact.base = random_.below(static_cast<int>(model_.surfaces.size()) - 1);
      contact.follower = static_cast<int>(model_.surfaces.size()) - 1;
      if (is_joined(model_.surfaces[static_cast<std::size_t>(contact.base)].body, i)) contact.base = 0;
      contact.stiffness = 20 / size_;
      contact.exponent = random_.chance(0.3) ? 1.5 : 1;
      contact.damping = 0.1;
      contact.friction = random_.chance(0.5) ? 0.3 : 0;
      contact.slip_speed = 0.1;
      model_.contacts.push_back(contact);
    }
    model_.contact_substeps = random_.chance(0.5) ? 1 << random_.below(4) : kAutomaticSubsteps;
  }

  void add_loops() {
    const int count = random_.below(4);
    for (int i = 0; i < count && model_.bodies.size() > 2; ++i) {
      int base = 0, follower = 0;
      draw_pair(base, follower);
      if (base == kGround || base == follower) continue;
      Joint joint = build_closing_joint(model_, base, follower, random_);
      joint.modes = {{"open", 0}, {"held", static_cast<RowSet>(1 + random_.below(7))}};
      model_.joints.push_back(joint);
      act_when_time(random_.uniform(0.002, 0.02), static_cast<int>(model_.joints.size()) - 1, 1);
    }
  }

  void add_laws() {
    const int count = draw_count(3);
    for (int i = 0; i < count; ++i) {
      Quantity speed;
      speed.name = "speed" + std::to_string(i);
      speed.kind = Quantity::Kind::kVelocity;
      speed.subject = draw_body();
      speed.part = Quantity::kSize;
      model_.quantities.push_back(speed);
      Law law;
      law.name = "law" + std::to_string(i);
      using Kind = LawStep::Kind;
      law.steps = {{Kind::kQuantity, static_cast<int>(model_.quantities.size()) - 1, 0}};
      const int steps = draw_count(12);
      for (int k = 0; k < steps; ++k) {
        constexpr Kind kOne[] = {Kind::kNegate, Kind::kSin, Kind::kCos, Kind::kAtan, Kind::kAbs};
        constexpr Kind kTwo[] = {Kind::kAdd, Kind::kSubtract, Kind::kMultiply, Kind::kMin, Kind::kMax, Kind::kAtan2};
        if (random_.chance(0.5)) {
          law.steps.push_back({kOne[random_.below(5)], 0, 0});
        } else {
          law.steps.push_back({Kind::kConstant, 0, random_.uniform(-1, 1)});
          law.steps.push_back({kTwo[random_.below(6)], 0, 0});
        }
      }
      model_.laws.push_back(law);
      if (random_.chance(0.3)) continue;
      Load load;
      load.name = "law_load" + std::to_string(i);
      load.body = draw_body();
      load.direction = {0.01, 0, 0};
      load.profile.kind = Profile::Kind::kLaw;
      load.profile.law = i;
      model_.loads.push_back(load);
    }
  }

  void add_sensors() {
    using Kind = Sensor::Kind;
    const int count = draw_count(16);
    for (int i = 0; i < count; ++i) {
      Sensor sensor;
      sensor.name = "sensor" + std::to_string(i);
      constexpr Kind kOfBody[] = {Kind::kPosition, Kind::kAttitude, Kind::kVelocity, Kind::kRate, Kind::kSpecificForce};
      sensor.kind = kOfBody[random_.below(5)];
      sensor.subject = draw_body();
      if (!model_.joints.empty() && random_.chance(0.4)) {
        constexpr Kind kOfJoint[] = {Kind::kReaction, Kind::kAngle, Kind::kDisplacement, Kind::kSpeed};
        const int kind = random_.below(4);
        sensor.kind = kOfJoint[kind];
        sensor.subject = random_.below(static_cast<int>(model_.joints.size()));
        sensor.axis = kind == 2 ? random_.below(3) : (kind == 1 ? 3 + random_.below(3) : random_.below(6));
      }
      model_.sensors.push_back(sensor);
    }
  }

  void add_events() {
    model_.signals.push_back("signal");
    const int count = draw_count(10);
    for (int i = 0; i < count; ++i) {
      if (model_.joints.empty()) break;
      const int joint = random_.below(static_cast<int>(model_.joints.size()));
      const auto& modes = model_.joints[static_cast<std::size_t>(joint)].modes;
      Condition condition;
      condition.kind = Condition::Kind::kTime;
      condition.threshold = random_.uniform(0, 0.03);
      if (random_.chance(0.5)) {
        condition.kind = random_.chance(0.5) ? Condition::Kind::kReaction : Condition::Kind::kSpeed;
        condition.subject = joint;
        condition.axis = condition.kind == Condition::Kind::kReaction ? draw_held_row(modes) : random_.below(6);
        condition.threshold = random_.uniform(-1, 1);
        condition.below = random_.chance(0.5);
        if (condition.axis == kNone) condition = {};  // time, from the start on
      }
      Event event;
      event.name = "event" + std::to_string(i);
      event.when = condition;
      event.delay = random_.chance(0.2) ? random_.uniform(0, 0.01) : 0;
      Action action;
      action.kind = Action::Kind::kSetMode;
      action.subject = joint;
      action.mode = random_.below(static_cast<int>(modes.size()));
      if (random_.chance(0.3)) {
        action = {};
        action.kind = Action::Kind::kRaise;
        action.value = 1;
      }
      event.then = {action};
      event.repeat = random_.chance(0.2);
      model_.events.push_back(event);
    }
  }

 private:
  // A row that some mode has; kNone if no mode has one.
  int draw_held_row(const std::vector<JointMode>& modes) {
    RowSet rows = 0;
    for (const JointMode& mode : modes) rows = static_cast<RowSet>(rows | mode.rows);
    if (rows == 0) return kNone;
    int row = random_.below(kRows);
    while (!has_row(rows, row)) row = (row + 1) % kRows;
    return row;
  }
  // Often none; otherwise up to `most`.
  int draw_count(int most) { return random_.chance(0.4) ? 0 : 1 + random_.below(most); }
  int draw_body() { return random_.below(static_cast<int>(model_.bodies.size())); }
  void draw_pair(int& base, int& follower) {
    follower = draw_body();
    base = draw_body();
    if (base == follower) base = kGround;
  }
  Vector3d draw_vector(double size) {
    return {random_.uniform(-size, size), random_.uniform(-size, size), random_.uniform(-size, size)};
  }

  Profile draw_profile() {
    Profile profile;
    profile.kind = static_cast<Profile::Kind>(random_.below(4));
    profile.initial = 1;
    profile.tau = 0.2;
    profile.times = {0, 0.05, 0.1, 0.2, 0.5};
    profile.values = {0, 1, 0.5, 0.2, 0};
    if (profile.kind == Profile::Kind::kHarmonic)
      for (int i = 1 + random_.below(4); i > 0; --i) profile.harmonics.push_back({0.5, 3.0 * i, 0.1 * i});
    return profile;
  }

  void add_joint_springs() {
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      const RowSet rows = joint.modes[static_cast<std::size_t>(joint.mode)].rows;
      const int axis = random_.below(kRows);
      if (joint.universal || has_row(rows, axis) || random_.chance(0.6)) continue;
      if (random_.chance(0.4) && (rows & kPointRows) != 0) {
        JointFriction friction;
        friction.name = "friction" + std::to_string(j);
        friction.joint = static_cast<int>(j);
        friction.axis = axis;
        friction.coefficient = 0.1;
        friction.radius = axis >= kRotX ? 0.1 : 0;
        friction.speed = 0.5;
        model_.frictions.push_back(friction);
        continue;
      }
      JointSpring spring;
      spring.name = "joint_spring" + std::to_string(j);
      spring.joint = static_cast<int>(j);
      spring.axis = axis;
      spring.stiffness = 1;
      spring.damping = 0.05;
      spring.implicit = random_.chance(0.15);
      model_.joint_springs.push_back(spring);
    }
  }

  geometry::ShapeKind draw_kind(bool convex) {
    using Kind = geometry::ShapeKind;
    constexpr Kind kConvex[] = {Kind::kBox, Kind::kCylinder, Kind::kCone, Kind::kCapsule, Kind::kSphere};
    return convex ? kConvex[random_.below(5)] : kConvex[3 + random_.below(2)];
  }
  geometry::Shape build_shape(geometry::ShapeKind kind) {
    geometry::Shape shape;
    shape.kind = kind;
    shape.radius = random_.uniform(0.1, 0.4);
    shape.radius *= size_;
    const Vector3d from = draw_vector(0.3), to = from + size_ * Vector3d(0.2, 0.1, 0.4);
    shape.from = {from.x(), from.y(), from.z()};
    shape.to = {to.x(), to.y(), to.z()};
    shape.size = {0.3 * size_, 0.4 * size_, 0.5 * size_};
    shape.normal = {0, 0, 1};
    if (kind == geometry::ShapeKind::kHalfSpace) shape.from = {0, 0, size_ - 5};
    return shape;
  }

  bool is_joined(int a, int b) const {
    return std::any_of(model_.joints.begin(), model_.joints.end(), [&](const Joint& joint) {
      return (joint.base == a && joint.follower == b) || (joint.base == b && joint.follower == a);
    });
  }

  void act_when_time(double t, int joint, int mode) {
    Event event;
    event.name = "close" + std::to_string(joint);
    event.when.kind = Condition::Kind::kTime;
    event.when.threshold = t;
    Action action;
    action.kind = Action::Kind::kSetMode;
    action.subject = joint;
    action.mode = mode;
    event.then = {action};
    model_.events.push_back(event);
  }

  Model& model_;
  Random& random_;
  double size_ = 1;  // of shapes
};

}  // namespace

void add_random_elements(Model& model, Random& random) {
  Adder add(model, random);
  add.add_loads();
  add.add_springs();
  if (random.chance(0.4)) add.add_one_sided();
  if (random.chance(0.4)) add.add_loops();
  if (random.chance(0.4)) add.add_laws();
  if (random.chance(0.3)) add.add_contacts(random.chance(0.5));
  add.add_sensors();
  add.add_events();
  if (!model.contacts.empty()) add_contact_events(model);
}

Model build_random_system(std::uint64_t seed) {
  Random random(seed ^ 0x5eed);
  RandomModelOptions options;
  options.bodies = 1 + random.below(random.chance(0.2) ? 48 : 12);
  Model model = build_random_model(seed, options);
  if (random.chance(0.5)) model.gravity.uniform = {0, 0, -1};
  if (random.chance(0.2)) {
    model.gravity.mu = 3.986004418e14;
    model.gravity.centre = {0, 0, -6.778e6};
  }
  if (!random.chance(0.25)) add_random_elements(model, random);
  return model;
}

}  // namespace unlatch::test
