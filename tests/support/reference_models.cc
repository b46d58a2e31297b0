#include "tests/support/reference_models.h"

#include <cmath>
#include <fstream>

namespace unlatch::test {
namespace {

using nlohmann::json;

constexpr RowSet kBallRows = kPointRows;

Condition reaction(int joint, int row, bool below) {
  Condition c;
  c.kind = Condition::Kind::kReaction;
  c.subject = joint;
  c.axis = row;
  c.below = below;
  return c;
}

Condition mode_is(int joint, int mode) {
  Condition c;
  c.kind = Condition::Kind::kMode;
  c.subject = joint;
  c.axis = mode;
  return c;
}

Condition all(std::vector<Condition> parts) {
  Condition c;
  c.kind = Condition::Kind::kAll;
  c.parts = std::move(parts);
  return c;
}

Action set_mode(int joint, int mode) {
  Action a;
  a.kind = Action::Kind::kSetMode;
  a.subject = joint;
  a.mode = mode;
  return a;
}

Action switch_element(int element, double value) {
  Action a;
  a.kind = Action::Kind::kSwitch;
  a.subject = element;
  a.value = value;
  return a;
}

Action raise(int signal) {
  Action a;
  a.kind = Action::Kind::kRaise;
  a.subject = signal;
  a.value = 1;
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

Load thrust(const std::string& name, int body, const json& point, const json& direction, const Profile& profile,
            bool on) {
  Load load;
  load.name = name;
  load.body = body;
  load.point = to_vector(point);
  load.direction = to_vector(direction);
  load.profile = profile;
  load.on = on;
  return load;
}

Body body(const std::string& name, double mass, const json& inertia) {
  Body b;
  b.name = name;
  b.mass = mass;
  b.inertia = to_matrix(inertia);
  return b;
}

void add_booster(Model& model, const json& parameters, const json& p, int k) {
  const std::string id = std::to_string(k);
  model.bodies.push_back(body("booster" + id, p["m"], p["J"]));
  const double azimuth = p["azimuth"], beta = p["beta"];
  const Eigen::Vector3d ex(1, 0, 0), er(0, std::cos(azimuth), std::sin(azimuth));

  Joint joint;
  joint.name = "nose" + id;
  joint.base = 0;
  joint.follower = k;
  joint.point_base = p["hinge_axial"].get<double>() * ex + p["hinge_radius"].get<double>() * er;
  joint.point_follower = to_vector(p["r_nose"]);
  const Eigen::Vector3d nx = std::cos(beta) * ex + std::sin(beta) * er, nz = -std::sin(beta) * ex + std::cos(beta) * er;
  joint.axes << nx, nz.cross(nx),
      nz;  // the reference's n_y points the other way, which changes no row but the sign of y
  const RowSet slider = row_bit(kY) | row_bit(kZ) | row_bit(kRotX) | row_bit(kRotZ);
  joint.modes = {{"hinge", static_cast<RowSet>(slider | row_bit(kX))}, {"slider", slider}, {"free", 0}};
  model.joints.push_back(joint);

  const int nozzle = static_cast<int>(model.loads.size()) + 1;
  model.loads.push_back(
      thrust("main" + id, k, p["thrust_point"], p["thrust_dir"], exponential(p["thrust0"], 0, p["thrust_tau"]), true));
  model.loads.push_back(thrust("nozzle" + id, k, p["nozzle_point"], p["nozzle_dir"],
                               exponential(0, p["nozzle_force"], p["nozzle_tau"]), false));
  model.signals.push_back("kr" + id);

  const int j = k - 1;
  Condition slipped;
  slipped.kind = Condition::Kind::kDisplacement;
  slipped.subject = j;
  slipped.axis = kX;
  slipped.threshold = -parameters["kr_distance"].get<double>();
  slipped.below = true;
  Condition contact;
  contact.kind = Condition::Kind::kSignal;
  contact.subject = j;
  const std::string subject = "booster" + id;
  model.events.push_back(
      {"release", subject, all({reaction(j, kX, false), mode_is(j, 0)}), 0, {set_mode(j, 1)}, false});
  model.events.push_back({"contact", subject, slipped, 0, {raise(j)}, false});
  model.events.push_back({"nozzle", subject, contact, parameters["nozzle_delay"], {switch_element(nozzle, 1)}, false});
  model.events.push_back({"liftoff", subject, all({reaction(j, kZ, true), mode_is(j, 1)}), 0, {set_mode(j, 2)}, false});
}

Joint array_hinge(const json& p, int parent, const char* stowed) {
  const std::string i = std::to_string(parent), j = std::to_string(parent + 1);
  Joint joint;
  joint.name = "hinge" + j;
  joint.base = parent;
  joint.follower = parent + 1;
  joint.point_base = to_vector(p["point_on_" + i]);
  joint.point_follower = to_vector(p["point_on_" + j]);
  joint.follower_axes = to_matrix(p[stowed]).transpose();
  joint.modes = {{"hinge", static_cast<RowSet>(kPointRows | row_bit(kRotX) | row_bit(kRotY))}};
  return joint;
}

// Adds the drive of one hinge, and the elastic latch that replaces it when the panel reaches its angle.
void add_latch(Model& model, const json& p, int j, int drive, int latch) {
  const double sign = p["sign"], lock = p["lock_angle"];
  Condition reached;
  reached.kind = Condition::Kind::kAngle;
  reached.subject = j;
  reached.axis = kRotZ;
  reached.threshold = sign * lock;
  reached.below = sign < 0;
  const std::string id = std::to_string(j + 1);
  model.events.push_back(
      {"latch" + id, "hinge" + id, reached, 0, {switch_element(drive, 0), switch_element(latch, 1)}, false});
}

JointSpring spring(const std::string& name, int joint, double effort, double stiffness, double damping, double rest,
                   bool on) {
  JointSpring s;
  s.name = name;
  s.joint = joint;
  s.effort = effort;
  s.stiffness = stiffness;
  s.damping = damping;
  s.rest = rest;
  s.on = on;
  return s;
}

// Frame of two unit vectors across the axis, as columns u and v, and the axis.
Eigen::Matrix3d rotation_frame(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  Eigen::Matrix3d axes;
  axes << u, v, u.cross(v);
  return axes;
}

}  // namespace

Eigen::Vector3d to_vector(const json& a) { return {a[0].get<double>(), a[1].get<double>(), a[2].get<double>()}; }

Eigen::Matrix3d to_matrix(const json& rows) {
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r) m.row(r) = to_vector(rows[static_cast<std::size_t>(r)]).transpose();
  return m;
}

void set_state(Body& b, const json& s) {
  const auto at = [&](std::size_t i) { return s[i].get<double>(); };
  b.p_WB = {at(0), at(1), at(2)};
  b.q_WB = Eigen::Quaterniond(at(3), at(4), at(5), at(6));
  b.v_WB = {at(7), at(8), at(9)};
  b.w_WB_B = {at(10), at(11), at(12)};
}

json load_reference(const std::string& name) {
  std::ifstream file(std::string(UNLATCH_TEST_DATA) + "/" + name + ".json");
  return json::parse(file);
}

Model build_soyuz(const json& reference) {
  const json& parameters = reference["params"];
  Model model;
  model.name = "boosters";
  model.gravity.uniform = to_vector(parameters["gravity"]);
  const json& core = parameters["core"];
  model.bodies.push_back(body("core", core["m"], core["J"]));
  Profile constant;
  constant.value = core["thrust"];
  model.loads.push_back(thrust("core_thrust", 0, core["thrust_point"], core["thrust_dir"], constant, true));
  int k = 1;
  for (const json& booster : parameters["boosters"]) add_booster(model, parameters, booster, k++);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    set_state(model.bodies[b], reference["trajectory"]["0.0"]["states"][b]);
  return model;
}

Model build_solar(const json& reference) {
  const json& p = reference["params"];
  Model model;
  model.name = "array";
  const char* names[] = {"bus", "panel1", "panel2"};
  for (std::size_t b = 0; b < 3; ++b) {
    model.bodies.push_back(body(names[b], p["bodies"][b]["m"], p["bodies"][b]["J"]));
    set_state(model.bodies[b], reference["initial_state"][b]);
  }
  model.joints.push_back(array_hinge(p["hinge1"], 0, "C01_stowed"));
  model.joints.push_back(array_hinge(p["hinge2"], 1, "C12_stowed"));
  for (int j = 0; j < 2; ++j) {
    const std::string id = std::to_string(j + 1);
    const json& s = p["spring" + id];
    const double sign = s["sign"];
    model.joint_springs.push_back(spring("drive" + id, j, sign * s["M0"].get<double>(), s["c"], s["d"], 0, true));
    model.joint_springs.push_back(
        spring("latch" + id, j, 0, s["k_lat"], s["d_lat"], sign * s["lock_angle"].get<double>(), false));
    add_latch(model, s, j, 2 * j, 2 * j + 1);
  }
  return model;
}

Model build_tree3(const json& reference) {
  Model model;
  model.name = "tree3";
  model.gravity.uniform = to_vector(reference["gravity"]);
  for (std::size_t b = 0; b < 3; ++b) {
    model.bodies.push_back(body("body" + std::to_string(b), reference["m"][b], reference["J"][b]));
    set_state(model.bodies[b], reference["initial_state"][b]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Load torque;
      torque.name = "torque" + std::to_string(b) + std::to_string(axis);
      torque.body = static_cast<int>(b);
      torque.kind = Load::Kind::kTorque;
      torque.direction = Eigen::Vector3d::Unit(static_cast<int>(axis));
      torque.profile.kind = Profile::Kind::kHarmonic;
      for (std::size_t h = 0; h < 3; ++h) {
        const json& c = reference["torque_coeffs"][b][3 * axis + h];
        torque.profile.harmonics.push_back({c["A"], c["w"], c["ph"]});
      }
      model.loads.push_back(torque);
    }
  }
  const json& ball = reference["spherical_0_1"];
  Joint spherical;
  spherical.name = "ball";
  spherical.base = 0;
  spherical.follower = 1;
  spherical.point_base = to_vector(ball["point_on_0"]);
  spherical.point_follower = to_vector(ball["point_on_1"]);
  spherical.modes = {{"ball", kBallRows}};
  const json& pin = reference["revolute_1_2"];
  Joint revolute;
  revolute.name = "pin";
  revolute.base = 1;
  revolute.follower = 2;
  revolute.point_base = to_vector(pin["point_on_1"]);
  revolute.point_follower = to_vector(pin["point_on_2"]);
  revolute.rotation_axes = rotation_frame(to_vector(reference["u"]), to_vector(reference["v"]));
  revolute.modes = {{"revolute", static_cast<RowSet>(kPointRows | row_bit(kRotX) | row_bit(kRotY))}};
  model.joints = {spherical, revolute};
  return model;
}

Model build_tree20(const json& reference) {
  Model model;
  model.name = "tree20";
  for (std::size_t b = 0; b < 20; ++b) {
    model.bodies.push_back(body("body" + std::to_string(b), reference["m"][b], reference["J"][b]));
    set_state(model.bodies[b], reference["states"][b]);
    const json& applied = reference["applied"][b];
    for (int kind = 0; kind < 2; ++kind) {
      Load load;
      load.name = (kind == 0 ? "force" : "torque") + std::to_string(b);
      load.body = static_cast<int>(b);
      load.kind = kind == 0 ? Load::Kind::kForce : Load::Kind::kTorque;
      load.frame = kind == 0 ? Load::Frame::kWorld : Load::Frame::kBody;
      for (int k = 0; k < 3; ++k) load.direction[k] = applied[static_cast<std::size_t>(3 * kind + k)];
      model.loads.push_back(load);
    }
  }
  for (const json& j : reference["joints"]) {
    Joint joint;
    joint.name = "joint" + std::to_string(model.joints.size());
    joint.base = j["parent"];
    joint.follower = j["child"];
    joint.point_base = to_vector(j["point_on_parent"]);
    joint.point_follower = to_vector(j["point_on_child"]);
    RowSet rows = kBallRows;
    if (j["rot_rows"].size() == 2) {
      joint.rotation_axes = rotation_frame(to_vector(j["rot_rows"][0]), to_vector(j["rot_rows"][1]));
      rows = static_cast<RowSet>(rows | row_bit(kRotX) | row_bit(kRotY));
    }
    joint.modes = {{j["type"], rows}};
    model.joints.push_back(joint);
  }
  return model;
}

}  // namespace unlatch::test
