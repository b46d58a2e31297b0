#include "tests/golden/golden_models.h"

#include "tests/support/contact_models.h"
#include "tests/support/random.h"
#include "tests/support/random_model.h"
#include "tests/support/small_models.h"
#include "unlatch/elementary.h"

namespace unlatch::test {
namespace {

using Eigen::Vector3d;
using Kind = Condition::Kind;

constexpr RowSet kSliderRows = row_bit(kY) | row_bit(kZ) | row_bit(kRotX) | row_bit(kRotZ);
constexpr double kHalfPi = 1.5707963267948966;

Condition all(std::vector<Condition> parts) {
  Condition c;
  c.kind = Kind::kAll;
  c.parts = std::move(parts);
  return c;
}

Condition below(Condition c) {
  c.below = true;
  return c;
}

Action act_switch(int element, double value, double duration = 0) {
  Action a;
  a.kind = duration > 0 ? Action::Kind::kRamp : Action::Kind::kSwitch;
  a.subject = element;
  a.value = value;
  a.duration = duration;
  return a;
}

Profile exponential(double initial, double final, double tau) {
  Profile p;
  p.kind = Profile::Kind::kExponential;
  p.initial = initial;
  p.final = final;
  p.tau = tau;
  return p;
}

Load force(const std::string& name, int body, const Vector3d& point, const Vector3d& direction, const Profile& profile,
           bool on = true) {
  Load load;
  load.name = name;
  load.body = body;
  load.point = point;
  load.direction = direction;
  load.profile = profile;
  load.on = on;
  return load;
}

Sensor sense(const std::string& name, Sensor::Kind kind, int subject, int axis = 0) {
  Sensor sensor;
  sensor.name = name;
  sensor.kind = kind;
  sensor.subject = subject;
  sensor.axis = axis;
  return sensor;
}

Attitude turn_about(const Vector3d& axis, double angle) {
  double sine, cosine;
  elementary::sincos(0.5 * angle, sine, cosine);
  return Attitude(cosine, sine * axis.x(), sine * axis.y(), sine * axis.z());
}

// --- Boosters: hinge → slider → free on reactions, a contact on a slip, a nozzle after a delay -----------------------

void add_booster(Model& model, int k) {
  const std::string id = std::to_string(k);
  const int j = k - 1;
  double sine, cosine;
  elementary::sincos(kHalfPi * j, sine, cosine);
  const Vector3d x(1, 0, 0), outwards(0, cosine, sine);
  const Attitude roll = turn_about(x, kHalfPi * j);

  Body booster = box("booster" + id, 4380, 5100, 121000, 120000);
  booster.q_WB = roll * turn_about({0, 0, 1}, -0.087);
  const Vector3d hinge = -0.8 * x + 1.32 * outwards, nose(13.2, 0, 0);
  booster.p_WB = hinge - booster.q_WB.toRotationMatrix() * nose;
  model.bodies.push_back(booster);

  Joint joint;
  joint.name = "nose" + id;
  joint.base = 0;
  joint.follower = k;
  joint.point_base = hinge;
  joint.point_follower = nose;
  double lean_sine, lean_cosine;
  elementary::sincos(0.06, lean_sine, lean_cosine);
  const Vector3d forward = lean_cosine * x + lean_sine * outwards, across = -lean_sine * x + lean_cosine * outwards;
  joint.axes << forward, across.cross(forward), across;
  joint.modes = {{"hinge", static_cast<RowSet>(kSliderRows | row_bit(kX))}, {"slider", kSliderRows}, {"free", 0}};
  model.joints.push_back(joint);

  const int nozzle = static_cast<int>(model.loads.size()) + 1;
  // Each engine's thrust decays differently, so that the boosters separate one after another.
  model.loads.push_back(
      force("main" + id, k, {-5.5, 0, 0}, {0.9962, 0.0869, 0}, exponential(300e3, 0, 0.34 + 0.01 * k)));
  model.loads.push_back(force("nozzle" + id, k, {12.2, 0, 0}, {-0.35, 0.94, 0}, exponential(0, 9000, 0.05), false));
  model.signals.push_back("contact" + id);
  model.sensors.push_back(sense("slip" + id, Sensor::Kind::kDisplacement, j, kX));
  model.sensors.push_back(sense("reaction" + id, Sensor::Kind::kReaction, j));

  const auto add_event = [&](const char* name, const Condition& condition, double delay, const Action& action) {
    model.events.push_back({name, booster.name, condition, delay, {action}, false});
  };
  add_event("release", all({when(Kind::kReaction, j, kX, 0), when(Kind::kMode, j, 0, 0)}), 0, act_set_mode(j, 1));
  add_event("contact", below(when(Kind::kDisplacement, j, kX, -0.045)), 0, act_raise(j));
  add_event("nozzle", when(Kind::kSignal, j, 0, 0), 0.02, act_switch(nozzle, 1));
  add_event("liftoff", all({below(when(Kind::kReaction, j, kZ, 0)), when(Kind::kMode, j, 1, 0)}), 0,
            act_set_mode(j, 2));
}

Model build_boosters() {
  Model model;
  model.name = "boosters";
  model.gravity.uniform = {-6.2, -7.4, 0};
  model.bodies.push_back(box("core", 98500, 105000, 11800000, 11800000));
  Profile thrust;
  thrust.value = 990e3;
  model.loads.push_back(force("core_thrust", 0, {-19.5, 0, 0}, {1, 0, 0}, thrust));
  for (int k = 1; k <= 4; ++k) add_booster(model, k);
  model.sensors.push_back(sense("rate", Sensor::Kind::kRate, 0));
  model.sensors.push_back(sense("specific_force", Sensor::Kind::kSpecificForce, 0));
  return model;
}

// --- An array: torsion drives, the first hinge latched by a stiff spring, the second rigidly
// --------------------------

Model build_array() {
  Model model;
  model.name = "array";
  Body bus = box("bus", 900, 420, 380, 510);
  bus.inertia(0, 1) = bus.inertia(1, 0) = 12;
  bus.w_WB_B = {0.01, -0.02, 0.015};
  Body panel1 = box("panel1", 12, 1.45, 4.02, 5.44), panel2 = box("panel2", 11, 1.33, 3.69, 4.99);
  panel1.q_WB = turn_about({0, 0, 1}, -kHalfPi);
  panel2.q_WB = turn_about({0, 0, 1}, kHalfPi);
  const Vector3d root(0.75, 0.9, 0.1), tip(1, 0, 0), end(-1, 0, 0);
  panel1.p_WB = root - panel1.q_WB.toRotationMatrix() * end;
  const Vector3d elbow = panel1.p_WB + panel1.q_WB.toRotationMatrix() * tip;
  panel2.p_WB = elbow - panel2.q_WB.toRotationMatrix() * end;
  for (Body* panel : {&panel1, &panel2}) {
    panel->v_WB = bus.w_WB_B.cross(panel->p_WB);
    panel->w_WB_B = panel->q_WB.toRotationMatrix().transpose() * bus.w_WB_B;
  }
  model.bodies = {bus, panel1, panel2};

  const double reached[] = {kHalfPi, -2 * kHalfPi};
  for (int j = 0; j < 2; ++j) {
    const std::string id = std::to_string(j + 1);
    Joint hinge;
    hinge.name = "hinge" + id;
    hinge.base = j;
    hinge.follower = j + 1;
    hinge.point_base = j == 0 ? root : tip;
    hinge.point_follower = end;
    hinge.modes = {{"hinge", kRevoluteRows}, {"latched", kWeldRows}};
    model.joints.push_back(hinge);
    JointSpring drive;
    drive.name = "drive" + id;
    drive.joint = j;
    drive.effort = j == 0 ? 1.9 : -1.6;
    drive.stiffness = 0.4;
    drive.damping = 0.1;
    model.joint_springs.push_back(drive);
    model.sensors.push_back(sense("angle" + id, Sensor::Kind::kAngle, j, kRotZ));
    model.sensors.push_back(sense("speed" + id, Sensor::Kind::kSpeed, j, kRotZ));
  }
  JointSpring latch;
  latch.name = "latch1";
  latch.stiffness = 1500;
  latch.damping = 9;
  latch.rest = reached[0];
  latch.on = false;
  model.joint_springs.push_back(latch);
  model.events.push_back(
      {"latch", "hinge1", when(Kind::kAngle, 0, kRotZ, reached[0]), 0, {act_switch(0, 0), act_switch(2, 1)}, false});
  model.events.push_back({"latch",
                          "hinge2",
                          below(when(Kind::kAngle, 1, kRotZ, reached[1])),
                          0,
                          {act_set_mode(1, 1), act_switch(1, 0, 0.5)},
                          false});
  return model;
}

// --- Every element: springs, a pusher, a plane torsion, all profiles, a central field
// ----------------------------------

void add_springs(Model& model) {
  PointSpring tether;
  tether.name = "tether";
  tether.base = 0;
  tether.follower = 1;
  tether.point_base = {0.5, 0.1, 0};
  tether.point_follower = {-0.4, 0, 0.1};
  tether.stiffness = 120;
  tether.damping = 2;
  tether.free_length = 1.1;
  PointSpring pusher = tether;
  pusher.name = "pusher";
  pusher.follower = 2;
  pusher.point_follower = {0, -0.3, 0};
  pusher.stiffness = 4000;
  pusher.free_length = 1.6;
  pusher.push_only = true;
  model.point_springs = {tether, pusher};

  JointSpring slide;
  slide.name = "slide";
  slide.axis = kX;
  slide.stiffness = 300;
  slide.damping = 1;
  slide.rest = 0.05;
  model.joint_springs.push_back(slide);
  PlaneTorsion torsion;
  torsion.name = "torsion";
  torsion.base = 0;
  torsion.follower = 2;
  torsion.stiffness = 15;
  torsion.damping = 0.2;
  model.plane_torsions.push_back(torsion);
}

Model build_elements() {
  Model model;
  model.name = "elements";
  model.gravity.mu = 3.986004418e14;
  model.gravity.centre = {0, 0, -6.778e6};
  model.bodies = {box("carrier", 40, 8, 9, 10), box("slider", 5, 0.4, 0.5, 0.6), box("free", 3, 0.3, 0.2, 0.25)};
  model.bodies[0].w_WB_B = {0.2, -0.1, 0.3};
  model.bodies[1].p_WB = {1.5, 0, 0};
  model.bodies[1].v_WB = model.bodies[0].w_WB_B.cross(model.bodies[1].p_WB);
  model.bodies[1].w_WB_B = model.bodies[0].w_WB_B;
  model.bodies[2].p_WB = {0.6, 1.5, 0.2};
  Joint guide;
  guide.name = "guide";
  guide.base = 0;
  guide.follower = 1;
  guide.point_base = {1.5, 0, 0};
  guide.modes = {{"guided", static_cast<RowSet>(kWeldRows & ~row_bit(kX))}, {"free", 0}};
  model.joints.push_back(guide);
  add_springs(model);

  Profile table;
  table.kind = Profile::Kind::kTable;
  table.times = {0, 0.3, 0.7, 1.1};
  table.values = {0, 6, -4, 1};
  Profile harmonic;
  harmonic.kind = Profile::Kind::kHarmonic;
  harmonic.harmonics = {{2, 7, 0.3}, {0.5, 31, 1.1}};
  model.loads.push_back(force("table", 0, {0, 0, 0.4}, {1, 0.2, 0}, table));
  model.loads.push_back(force("harmonic", 2, {0.1, 0, 0}, {0, 0.5, 1}, harmonic));
  model.loads.back().frame = Load::Frame::kWorld;
  model.loads.push_back(force("wheel", 0, {0, 0, 0}, {0, 0.3, 1}, harmonic, false));
  model.loads.back().kind = Load::Kind::kTorque;
  for (const auto kind : {Sensor::Kind::kPosition, Sensor::Kind::kAttitude, Sensor::Kind::kVelocity,
                          Sensor::Kind::kAcceleration, Sensor::Kind::kSpecificForce})
    model.sensors.push_back(sense("sensor" + std::to_string(model.sensors.size()), kind, 1));

  const int torsion = model.element_count() - 1;
  Event beat{"beat", "wheel", when(Kind::kDisplacement, 0, kX, 0.06), 0, {act_switch(2, 1, 0.1)}, true};
  Event rest{"rest", "wheel", below(when(Kind::kDisplacement, 0, kX, 0.04)), 0.013, {act_switch(2, 0)}, true};
  Event go{"go", "slider", when_time(1.23456), 0, {act_set_mode(0, 1), act_switch(torsion, 0, 0.2)}, false};
  model.events = {beat, rest, go};
  return model;
}

// --- Closed loops: a four-bar whose coupler is caught and let go, its rows three times redundant
// -----------------------

Body build_rod(const std::string& name, const Vector3d& from, const Vector3d& to, double angle) {
  Body rod = box(name, 1, 1e-3, 1.0 / 12, 1.0 / 12);
  rod.p_WB = 0.5 * (from + to);
  rod.q_WB = turn_about({0, 0, 1}, angle);
  return rod;
}

Model build_linkage() {
  Model model;
  model.name = "linkage";
  model.gravity.uniform = {0, -9.81, 0};
  const Vector3d points[] = {{0, 0, 0}, {0.2, 0.7, 0}, {1.9, 1.5, 0}, {2, 0, 0}};
  for (int k = 0; k < 3; ++k) {
    const Vector3d along = points[k + 1] - points[k];
    model.bodies.push_back(
        build_rod("rod" + std::to_string(k), points[k], points[k + 1], elementary::atan2(along.y(), along.x())));
  }
  for (int k = 0; k < 4; ++k) {
    Joint hinge;
    hinge.name = "hinge" + std::to_string(k);
    hinge.base = k == 3 ? kGround : k - 1;
    hinge.follower = k == 3 ? 2 : k;
    const auto place = [&](int b) -> Vector3d {
      if (b == kGround) return points[k];
      const Body& body = model.bodies[static_cast<std::size_t>(b)];
      return body.q_WB.toRotationMatrix().transpose() * (points[k] - body.p_WB);
    };
    hinge.point_base = place(hinge.base);
    hinge.point_follower = place(hinge.follower);
    hinge.modes = {{"hinge", kRevoluteRows}, {"ball", kPointRows}, {"open", 0}};
    model.joints.push_back(hinge);
    model.sensors.push_back(sense("reaction" + std::to_string(k), Sensor::Kind::kReaction, k));
  }
  model.events.push_back({"loosen", "", when_time(0.8), 0, {act_set_mode(1, 1)}, false});
  model.events.push_back({"tighten", "", when_time(1.2), 0, {act_set_mode(1, 0)}, false});
  model.events.push_back({"let go", "", when_time(1.7), 0, {act_set_mode(2, 2)}, false});
  return model;
}

// --- Random trees: joints of every kind, every body pushed, joints that change their modes
// -----------------------------

Model build_tree(std::uint64_t seed, int bodies) {
  RandomModelOptions options;
  options.bodies = bodies;
  Model model = build_random_model(seed, options);
  model.name = "tree" + std::to_string(bodies);
  Random random(seed);
  for (int b = 0; b < bodies; ++b) {
    Profile profile;
    profile.kind = Profile::Kind::kHarmonic;
    for (int k = 0; k < 2; ++k) {
      const double amplitude = random.uniform(0, 5), frequency = random.uniform(1, 9), phase = random.uniform(0, 6);
      profile.harmonics.push_back({amplitude, frequency, phase});
    }
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
    model.loads.push_back(force("push" + std::to_string(b), b, {z, x, y}, {x, y, z}, profile));
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const int modes = static_cast<int>(model.joints[j].modes.size());
    for (const char* name : {"first", "second"}) {
      const Condition at = when_time(random.uniform(0.1, 0.4));
      const Action change = act_set_mode(static_cast<int>(j), random.below(modes));
      model.events.push_back({name, model.joints[j].name, at, 0, {change}, false});
    }
  }
  return model;
}

}  // namespace

std::vector<GoldenModel> build_golden_models() {
  return {{build_boosters(), 1e-3, 1500},       {build_array(), 1e-3, 9000},        {build_elements(), 5e-4, 4000},
          {build_linkage(), 1e-3, 2500},        {build_tree(11, 8), 1e-3, 500},     {build_tree(12, 20), 1e-3, 500},
          {build_tree(13, 60), 1e-3, 500},      {build_pushers(), 1e-3, 1500},      {build_heap(8), 1e-3, 1500},
          {build_capsule_in_tube(), 1e-3, 300}, {build_sticking_block(), 1e-3, 300}};
}

}  // namespace unlatch::test
