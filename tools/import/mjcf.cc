// MJCF, read and completed by MuJoCo: bodies, inertias and defaults are those of MuJoCo's own computation.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "hil/scenario/text/count.h"
#include "tools/import/imported.h"
#include "tools/import/mjcf_rest.h"

namespace unlatch::tools {

namespace {

using Eigen::Isometry3d;
using Kind = ImportedJoint::Kind;

constexpr std::size_t kHullPoints = 256;

Eigen::Vector3d to_vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }

Isometry3d to_isometry(const mjtNum* p, const mjtNum* q) {
  Isometry3d X = Isometry3d::Identity();
  X.translate(to_vector(p));
  X.rotate(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized());
  return X;
}

struct Free {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using Model = std::unique_ptr<mjModel, Free>;

std::string get_name(const mjModel& m, int type, int index, const char* kind) {
  const char* const name = mj_id2name(&m, type, index);
  return name != nullptr && *name != 0 ? name : kind + std::to_string(index);
}

class Reader {
 public:
  Reader(const mjModel& m, ImportedModel& model) : m_(m), model_(model) {}

  void read() {
    if (static_cast<std::size_t>(m_.nbody) > kMostImported || static_cast<std::size_t>(m_.ngeom) > kMostImported) {
      throw ImportError("it has more than " + std::to_string(kMostImported) + " bodies or shapes");
    }
    owners_.assign(static_cast<std::size_t>(m_.nbody), -1);
    frames_.assign(static_cast<std::size_t>(m_.nbody), Isometry3d::Identity());
    for (int i = 1; i < m_.nbody; ++i) read_body(i);
    for (int i = 0; i < m_.ngeom; ++i) read_geom(i);
    for (int i = 0; i < m_.neq; ++i) read_equality(i);
    remark_on_the_rest();
  }

 private:
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }

  // Parents come before their children. A body without joints and mass, or fixed to the ground, is a frame.
  void read_body(int i) {
    const int parent = m_.body_parentid[i];
    frames_[at(i)] = frames_[at(parent)] * to_isometry(m_.body_pos + 3 * i, m_.body_quat + 4 * i);
    const int base = owners_[at(parent)];
    const std::string name = get_name(m_, mjOBJ_BODY, i, "body");
    const bool is_fixed = m_.body_jntnum[i] == 0;
    if (is_fixed && (base < 0 || !(m_.body_mass[i] > 0))) {
      owners_[at(i)] = base;
      return;
    }
    const Isometry3d X_BI = to_isometry(m_.body_ipos + 3 * i, m_.body_iquat + 4 * i);
    ImportedBody body;
    body.name = name;
    body.mass = m_.body_mass[i];
    body.inertia = X_BI.linear() * to_vector(m_.body_inertia + 3 * i).asDiagonal() * X_BI.linear().transpose();
    body.p_WB = frames_[at(i)] * X_BI.translation();
    body.q_WB = Eigen::Quaterniond(frames_[at(i)].linear()).normalized();
    model_.bodies.push_back(std::move(body));
    owners_[at(i)] = static_cast<int>(model_.bodies.size()) - 1;
    read_joints(i, base, name);
  }

  void read_joints(int i, int base, const std::string& body) {
    const int first = m_.body_jntadr[i], count = m_.body_jntnum[i];
    ImportedJoint joint;
    joint.base = base;
    joint.follower = owners_[at(i)];
    joint.p_WJ = frames_[at(i)].translation();
    joint.R_WJ = frames_[at(i)].linear();
    if (count == 0) {
      joint.name = body + "_weld";
      model_.joints.push_back(joint);
      return;
    }
    joint.name = get_name(m_, mjOBJ_JOINT, first, "joint");
    const Eigen::Vector3d axis = frames_[at(i)].linear() * to_vector(m_.jnt_axis + 3 * first);
    joint.p_WJ = frames_[at(i)] * to_vector(m_.jnt_pos + 3 * first);
    const int type = m_.jnt_type[first];
    if (count == 1 && type == mjJNT_FREE) {
      const mjtNum* const damping = m_.dof_damping + m_.jnt_dofadr[first];
      if (is_passive_ &&
          (m_.jnt_stiffness[first] != 0 || std::any_of(damping, damping + 6, [](mjtNum d) { return d != 0; })))
        model_.remarks.push_back("joint '" + joint.name + "': spring and damper of a free joint are left out");
      return;
    }
    if (count == 2 && is_universal(i, axis)) {
      joint.kind = Kind::kUniversal;
      joint.R_WJ.col(0) = axis.normalized();
      joint.R_WJ.col(1) = (frames_[at(i)].linear() * to_vector(m_.jnt_axis + 3 * (first + 1))).normalized();
      joint.R_WJ.col(2) = joint.R_WJ.col(0).cross(joint.R_WJ.col(1));
      if (has_elasticity(first) || has_elasticity(first + 1))
        model_.remarks.push_back("body '" + body + "': springs and dampers of its two hinges are left out");
      model_.joints.push_back(joint);
      return;
    }
    if (count > 1) {
      throw ImportError("body '" + body + "' has " + hil::count(count, "joint") +
                        "; a scenario has one joint between two bodies (two hinges that cross at right angles "
                        "are a universal joint): put bodies of their own, with mass, between them");
    }
    joint.kind = type == mjJNT_BALL ? Kind::kBall : type == mjJNT_SLIDE ? Kind::kPrismatic : Kind::kRevolute;
    if (type == mjJNT_BALL) {
      if (has_elasticity(first))
        model_.remarks.push_back("joint '" + joint.name + "': spring and damper of a ball joint are left out");
    } else {
      joint.R_WJ = build_frame(axis);
      if (is_passive_) {
        joint.stiffness = m_.jnt_stiffness[first];
        joint.damping = m_.dof_damping[m_.jnt_dofadr[first]];
      }
      const int q = m_.jnt_qposadr[first];
      joint.rest = m_.qpos_spring[q] - m_.qpos0[q];
    }
    model_.joints.push_back(joint);
  }

  [[nodiscard]] bool has_elasticity(int joint) const {
    return is_passive_ && (m_.jnt_stiffness[joint] != 0 || m_.dof_damping[m_.jnt_dofadr[joint]] != 0);
  }

  [[nodiscard]] bool is_universal(int i, const Eigen::Vector3d& axis) const {
    const int first = m_.body_jntadr[i];
    const Eigen::Vector3d other = frames_[at(i)].linear() * to_vector(m_.jnt_axis + 3 * (first + 1));
    return m_.jnt_type[first] == mjJNT_HINGE && m_.jnt_type[first + 1] == mjJNT_HINGE &&
           (to_vector(m_.jnt_pos + 3 * first) - to_vector(m_.jnt_pos + 3 * (first + 1))).norm() < 1e-12 &&
           std::abs(axis.normalized().dot(other.normalized())) < 1e-12;
  }

  void read_geom(int i) {
    const int owner = owners_[at(m_.geom_bodyid[i])];
    const std::string name = get_name(m_, mjOBJ_GEOM, i, "geom");
    if (owner < 0) {
      model_.remarks.push_back("geom '" + name + "': shapes of the ground are left out");
      return;
    }
    ImportedBody& body = model_.bodies[at(owner)];
    Isometry3d X_WB = Isometry3d::Identity();
    X_WB.translate(body.p_WB);
    X_WB.rotate(body.q_WB);
    const Isometry3d X_BS =
        X_WB.inverse() * frames_[at(m_.geom_bodyid[i])] * to_isometry(m_.geom_pos + 3 * i, m_.geom_quat + 4 * i);
    const mjtNum* const size = m_.geom_size + 3 * i;
    geometry::Shape shape;
    shape.from = to_vec3(X_BS.translation());
    shape.radius = size[0];
    switch (m_.geom_type[i]) {
      case mjGEOM_SPHERE:
        shape.kind = geometry::ShapeKind::kSphere;
        break;
      case mjGEOM_CAPSULE:
      case mjGEOM_CYLINDER:
        shape.kind = m_.geom_type[i] == mjGEOM_CAPSULE ? geometry::ShapeKind::kCapsule : geometry::ShapeKind::kCylinder;
        shape.from = to_vec3(X_BS * Eigen::Vector3d(0, 0, -size[1]));
        shape.to = to_vec3(X_BS * Eigen::Vector3d(0, 0, size[1]));
        break;
      case mjGEOM_BOX:
        shape.kind = geometry::ShapeKind::kBox;
        shape.size = to_vec3(2 * to_vector(size));
        shape.q_BS = to_quat(Eigen::Quaterniond(X_BS.linear()).normalized());
        break;
      case mjGEOM_MESH:
        shape.kind = geometry::ShapeKind::kHull;
        for (const Eigen::Vector3d& p : build_hull(m_.geom_dataid[i], X_BS, name)) shape.points.push_back(to_vec3(p));
        break;
      default:
        model_.remarks.push_back("geom '" + name + "': its shape is left out (plane, height field or ellipsoid)");
        return;
    }
    body.shapes.push_back(std::move(shape));
  }

  // The vertices; of a fine mesh those that stand out farthest in evenly spread directions.
  std::vector<Eigen::Vector3d> build_hull(int mesh, const Isometry3d& X_BS, const std::string& name) {
    std::vector<Eigen::Vector3d> all, chosen;
    for (int v = 0; v < m_.mesh_vertnum[mesh]; ++v) {
      const float* const p = m_.mesh_vert + 3 * (m_.mesh_vertadr[mesh] + v);
      all.push_back(X_BS *
                    Eigen::Vector3d(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])));
    }
    model_.remarks.push_back("geom '" + name + "': the convex hull of its mesh");
    if (all.size() <= kHullPoints) return all;
    model_.remarks.back() += ", through at most " + std::to_string(kHullPoints) + " of its outermost points";
    std::vector<bool> taken(all.size());
    for (std::size_t k = 0; k < kHullPoints; ++k) {
      const double z = 1 - (2 * static_cast<double>(k) + 1) / static_cast<double>(kHullPoints),
                   turn = 2.399963229728653 * static_cast<double>(k);
      const Eigen::Vector3d direction(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
      std::size_t best = 0;
      for (std::size_t v = 1; v < all.size(); ++v) {
        if (direction.dot(all[v]) > direction.dot(all[best])) best = v;
      }
      if (!taken[best]) chosen.push_back(all[best]);
      taken[best] = true;
    }
    return chosen;
  }

  // Loops: a point or a whole body held to another.
  void read_equality(int i) {
    const std::string name = get_name(m_, mjOBJ_EQUALITY, i, "equality");
    const int type = m_.eq_type[i];
    const bool is_off = (m_.opt.disableflags & (mjDSBL_EQUALITY | mjDSBL_CONSTRAINT)) != 0 || m_.eq_active[i] == 0;
    if (is_off) {
      model_.remarks.push_back("equality '" + name + "' is left out: it is switched off");
      return;
    }
    if (type != mjEQ_CONNECT && type != mjEQ_WELD) {
      model_.remarks.push_back("equality '" + name + "' is left out");
      return;
    }
    const int one = m_.eq_obj1id[i], two = m_.eq_obj2id[i];
    ImportedJoint joint;
    joint.name = name;
    joint.kind = type == mjEQ_CONNECT ? Kind::kBall : Kind::kWeld;
    joint.base = owners_[at(one)];
    joint.follower = owners_[at(two)];
    joint.p_WJ = type == mjEQ_CONNECT ? frames_[at(one)] * to_vector(m_.eq_data + mjNEQDATA * i)
                                      : frames_[at(two)].translation();
    if (type == mjEQ_WELD) check_weld(i, name);
    if (joint.follower < 0) std::swap(joint.base, joint.follower);
    if (joint.follower < 0 || joint.base == joint.follower) {
      model_.remarks.push_back("equality '" + name + "' is left out: both sides are one body");
      return;
    }
    model_.joints.push_back(joint);
  }

  // A joint of a scenario fits at the start; MuJoCo would pull the bodies into another relative pose.
  void check_weld(int i, const std::string& name) const {
    constexpr double kFits = 1e-6;                          // m, rad
    const mjtNum* const data = m_.eq_data + mjNEQDATA * i;  // anchor in the second body; its pose in the first one
    const Isometry3d wanted = to_isometry(data + 3, data + 6);
    Isometry3d anchor = Isometry3d::Identity();
    anchor.translate(to_vector(data));
    const Isometry3d off =
        wanted.inverse() * frames_[at(m_.eq_obj1id[i])].inverse() * frames_[at(m_.eq_obj2id[i])] * anchor;
    if (off.translation().norm() > kFits || Eigen::AngleAxisd(off.linear()).angle() > kFits)
      throw ImportError(
          "equality '" + name +
          "' welds its bodies in another relative pose (relpose) than the one in which they are: place the "
          "bodies so that they fit, or remove relpose");
  }

  void remark_on_the_rest() {
    const auto leave_out = [this](int count, const char* what) {
      if (count > 0) model_.remarks.push_back("left out: " + std::to_string(count) + " " + what);
    };
    leave_out(m_.nu, "actuators: write channels and elements");
    leave_out(m_.ntendon, "tendons");
    leave_out(m_.nsensor, "sensors");
    int limits = 0, friction = 0, armature = 0;
    for (int i = 0; i < m_.njnt; ++i) limits += m_.jnt_limited[i] != 0 ? 1 : 0;
    for (int i = 0; i < m_.nv; ++i) {
      friction += m_.dof_frictionloss[i] > 0 ? 1 : 0;
      armature += m_.dof_armature[i] > 0 ? 1 : 0;
    }
    leave_out(limits, "ranges of joints: nothing stops them");
    leave_out(friction, "dry frictions of joints");
    leave_out(armature, "armatures (inertia of rotors)");
    for (std::string& remark : list_unread(m_)) model_.remarks.push_back(std::move(remark));
    if ((m_.opt.disableflags & mjDSBL_PASSIVE) != 0)
      model_.remarks.push_back("springs and dampers are left out: the flag 'passive' disables them");
    model_.remarks.push_back("contacts between bodies are left out");
    model_.remarks.push_back("every joint is at its reference, and nothing moves");
  }

  const mjModel& m_;
  ImportedModel& model_;
  const bool is_passive_ = (m_.opt.disableflags & mjDSBL_PASSIVE) == 0;  // there are springs and dampers
  std::vector<int> owners_;                                              // of each of its bodies: ours, or -1
  std::vector<Isometry3d> frames_;                                       // X_WB of each of its bodies
};

}  // namespace

ImportedModel read_mjcf(const std::string& path) {
  char error[1000] = "";
  const Model loaded(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
  if (!loaded) throw ImportError(std::string("MuJoCo cannot read it: ") + error);
  ImportedModel model;
  const std::string names = loaded->names;  // the model's name comes first
  model.name = names;
  model.source = "MJCF, " + path + ", read by MuJoCo " + mj_versionString();
  model.dt = loaded->opt.timestep;
  model.gravity =
      (loaded->opt.disableflags & mjDSBL_GRAVITY) != 0 ? Eigen::Vector3d::Zero() : to_vector(loaded->opt.gravity);
  Reader(*loaded, model).read();
  return model;
}

}  // namespace unlatch::tools
