// URDF, read by urdfdom. A link without mass is a frame of the body that carries it; a root without mass is the ground.
#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <set>

#include "hil/scenario/text/count.h"
#include "tools/import/imported.h"
#include "tools/import/urdf_text.h"

namespace unlatch::tools {
namespace {

using Eigen::Isometry3d;
using Kind = ImportedJoint::Kind;

// Error messages of urdfdom.
class Listener final : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_WARN && said.size() < 400)
      said += (said.empty() ? "" : "; ") + text;
    failed = failed || level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR;
  }
  std::string said;
  bool failed = false;  // it reads on after a mistake, as if the element were not there
};

Eigen::Vector3d to_vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Isometry3d to_isometry(const urdf::Pose& pose) {
  Isometry3d X = Isometry3d::Identity();
  X.translate(to_vector(pose.position));
  X.rotate(Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z).normalized());
  return X;
}

// A rotation by right angles that was typed as 1.5708 is one: entries this near to 0 and 1 are them.
bool snap_right_angles(Isometry3d& X) {
  constexpr double kTyped = 1e-5;
  const Eigen::Matrix3d near = X.linear().array().round();
  const double off = (X.linear() - near).cwiseAbs().maxCoeff();
  if (off > kTyped) return false;
  X.linear() = near;
  return off > 1e-12;  // beyond the rounding of a double
}

// Pose of a link, and the body to which it belongs.
struct Placed {
  int body = -1;  // the ground
  Isometry3d X_WL = Isometry3d::Identity();
  std::vector<std::pair<const urdf::Joint*, Eigen::Vector3d>> hinges = {};  // of crosses without mass between it and
                                                                            // its carrier, and their axes in W
};

class Reader {
 public:
  Reader(const UrdfText& text, ImportedModel& model, bool fixed_base)
      : text_(text), model_(model), fixed_base_(fixed_base) {}

  void read(const urdf::ModelInterface& robot) {
    std::vector<std::pair<urdf::LinkConstSharedPtr, Placed>> waiting{{robot.getRoot(), place_root(*robot.getRoot())}};
    std::set<std::string> reached;
    while (!waiting.empty()) {
      const auto [link, placed] = waiting.back();
      waiting.pop_back();
      if (!reached.insert(link->name).second) throw ImportError(describe_parents(robot, *link));
      for (const urdf::JointSharedPtr& joint : link->child_joints) {
        const auto child = robot.getLink(joint->child_link_name);
        if (!child)
          throw ImportError(quote("joint", joint->name) + " leads to link '" + joint->child_link_name +
                            "', which is not there");
        waiting.emplace_back(child, place_child(*joint, *child, placed));
      }
    }
    for (const auto& [name, link] : robot.links_) {
      if (!reached.contains(name))
        throw ImportError(quote("link", name) + " is not connected to the root '" + robot.getRoot()->name +
                          "': a cycle, or a second tree");
    }
  }

 private:
  // Line of a link or joint; 0 if it is not known.
  [[nodiscard]] int get_line(const char* kind, const std::string& name) const {
    const auto at = text_.lines.find({kind, name});
    return at == text_.lines.end() ? 0 : at->second;
  }
  [[nodiscard]] std::string quote(const char* kind, const std::string& name) const {
    const int line = get_line(kind, name);
    return (line == 0 ? "" : "line " + std::to_string(line) + ": ") + kind + " '" + name + "'";
  }

  // The mistake of a link that is reached twice.
  [[nodiscard]] std::string describe_parents(const urdf::ModelInterface& robot, const urdf::Link& link) const {
    std::string joints;
    int count = 0;
    for (const auto& [name, joint] : robot.joints_) {
      if (joint->child_link_name != link.name) continue;
      joints += (count++ == 0 ? "" : ", ") + ("'" + name + "'");
    }
    return quote("link", link.name) +
           (count > 1 ? " is the child of " + hil::count(count, "joint") + ", " + joints +
                            ": a URDF is a tree; a loop is closed in the scenario, by a joint there"
                      : " is its own ancestor: a URDF is a tree");
  }

  static bool has_mass(const urdf::Link& link) { return link.inertial && link.inertial->mass != 0; }

  Placed place_root(const urdf::Link& link) {
    Placed placed;
    if (!has_mass(link)) {
      model_.remarks.push_back("root link '" + link.name + "' has no mass: it is the ground");
      add_shapes(link, placed, Isometry3d::Identity());
      return placed;
    }
    placed.body = add_body(link, placed.X_WL);
    if (fixed_base_) {
      add_joint("root", Kind::kWeld, -1, placed.body, placed.X_WL);
    } else {
      model_.remarks.push_back("root link '" + link.name +
                               "' has mass: it flies free; --fixed-base welds it to the ground");
    }
    return placed;
  }

  Placed place_child(const urdf::Joint& joint, const urdf::Link& child, const Placed& parent) {
    Placed placed{parent.body, parent.X_WL * place(joint.parent_to_joint_origin_transform)};
    const bool is_fixed = joint.type == urdf::Joint::FIXED;
    if (!has_mass(child)) {
      constexpr std::size_t kMostCrosses = 2;
      if (!is_fixed && parent.hinges.size() < kMostCrosses && is_cross(joint, child)) {
        placed.hinges = parent.hinges;
        placed.hinges.emplace_back(&joint, (placed.X_WL.linear() * get_axis(joint)).normalized());
        return placed;
      }
      if (!is_fixed || !parent.hinges.empty()) {
        throw ImportError(
            quote("link", child.name) + " has no mass, but joint '" + joint.name +
            "' lets it move: give it an <inertial>, or make the joint fixed (a link between two hinges whose "
            "axes cross at right angles needs no mass: the two are a universal joint, three in one point a ball "
            "joint)");
      }
      if (placed.body >= 0) add_shapes(child, placed, get_frame(placed.body));
      return placed;
    }
    const int base = placed.body;
    placed.body = add_body(child, placed.X_WL);
    Isometry3d X_WJ = placed.X_WL;
    if (!parent.hinges.empty()) {
      add_gimbal(parent, joint, base, placed, X_WJ);
      return placed;
    }
    switch (joint.type) {
      case urdf::Joint::FIXED:
        add_joint(joint.name, Kind::kWeld, base, placed.body, X_WJ);
        break;
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
      case urdf::Joint::PRISMATIC:
      case urdf::Joint::PLANAR:
        X_WJ.linear() = build_frame(placed.X_WL.linear() * get_axis(joint));
        add_joint(joint.name,
                  joint.type == urdf::Joint::PRISMATIC ? Kind::kPrismatic
                  : joint.type == urdf::Joint::PLANAR  ? Kind::kPlanar
                                                       : Kind::kRevolute,
                  base, placed.body, X_WJ);
        break;
      case urdf::Joint::FLOATING:
        break;  // no joint at all
      default:
        throw ImportError(quote("joint", joint.name) + " has no type that is known");
    }
    add_remarks(joint);
    return placed;
  }

  // Two hinges with a cross between them are a universal joint, three with two crosses a ball joint.
  void add_gimbal(const Placed& parent, const urdf::Joint& last, int base, const Placed& placed, Isometry3d X_WJ) {
    const bool is_ball = parent.hinges.size() == 2;
    std::string names;
    for (const auto& hinge : parent.hinges) names += (names.empty() ? "'" : ", '") + hinge.first->name + "'";
    X_WJ.linear().col(0) = parent.hinges.back().second;
    X_WJ.linear().col(1) = (placed.X_WL.linear() * get_axis(last)).normalized();
    X_WJ.linear().col(2) = X_WJ.linear().col(0).cross(X_WJ.linear().col(1));
    add_joint(last.name, is_ball ? Kind::kBall : Kind::kUniversal, base, placed.body, X_WJ);
    model_.remarks.push_back("joints " + names + " and '" + last.name + "' with " +
                             (is_ball ? "the links between them, which have no mass, are one ball joint"
                                      : "the link between them, which has no mass, are one universal joint") +
                             "; damping, friction and ranges of them are left out");
  }

  static bool is_hinge(const urdf::Joint& joint) {
    return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
  }

  // A link between two hinges whose axes cross at right angles, in the point of both: without mass it does nothing else
  // than a universal joint does.
  [[nodiscard]] bool is_cross(const urdf::Joint& joint, const urdf::Link& link) const {
    constexpr double kExact = 1e-9;  // m, rad
    if (!is_hinge(joint) || link.child_joints.size() != 1) return false;
    const urdf::Joint& next = *link.child_joints.front();
    if (!is_hinge(next) || !link.collision_array.empty() || !link.visual_array.empty()) return false;
    Isometry3d X = to_isometry(next.parent_to_joint_origin_transform);
    (void)snap_right_angles(X);
    const Eigen::Vector3d one = get_axis(joint).normalized(), two = X.linear() * get_axis(next).normalized();
    return X.translation().norm() < kExact && std::abs(one.dot(two)) < kExact;
  }

  [[nodiscard]] Eigen::Vector3d get_axis(const urdf::Joint& joint) const {
    Eigen::Vector3d axis = to_vector(joint.axis);
    if (!(axis.norm() > 1e-9) || !axis.allFinite())
      throw ImportError(quote("joint", joint.name) + " has an axis without a direction");
    return axis;
  }

  void add_remarks(const urdf::Joint& joint) {
    ImportedJoint* const added = model_.joints.empty() ? nullptr : &model_.joints.back();
    if (joint.dynamics && added != nullptr && joint.type != urdf::Joint::FLOATING && joint.type != urdf::Joint::FIXED) {
      if (joint.type != urdf::Joint::PLANAR) added->damping = joint.dynamics->damping;
      if (joint.dynamics->friction != 0)
        model_.remarks.push_back("joint '" + joint.name + "': dry friction is left out");
    }
    const bool has_range =
        joint.limits && joint.type != urdf::Joint::CONTINUOUS && (joint.limits->lower != 0 || joint.limits->upper != 0);
    if (has_range) model_.remarks.push_back("joint '" + joint.name + "': its range is left out: nothing stops it");
    if (joint.mimic) model_.remarks.push_back("joint '" + joint.name + "': mimic is left out: it moves by itself");
  }

  Isometry3d place(const urdf::Pose& pose) {
    Isometry3d X = to_isometry(pose);
    if (snap_right_angles(X) && !told_angles_) {
      model_.remarks.push_back("angles within 1e-5 rad of right ones, such as 1.5708, are taken as right angles");
      told_angles_ = true;
    }
    return X;
  }

  // The body's axes and centre of mass in W.
  [[nodiscard]] Isometry3d get_frame(int body) const {
    const ImportedBody& at = model_.bodies[static_cast<std::size_t>(body)];
    Isometry3d X = Isometry3d::Identity();
    X.translate(at.p_WB);
    X.rotate(at.q_WB);
    return X;
  }

  int add_body(const urdf::Link& link, const Isometry3d& X_WL) {
    if (model_.bodies.size() == kMostImported)
      throw ImportError("it has more than " + std::to_string(kMostImported) + " bodies");
    const Isometry3d X_LI = place(link.inertial->origin);
    const urdf::Inertial& inertial = *link.inertial;
    Eigen::Matrix3d I;
    I << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz, inertial.ixz, inertial.iyz,
        inertial.izz;
    ImportedBody body;
    body.name = link.name;
    body.line = get_line("link", link.name);
    body.mass = inertial.mass;
    body.inertia = X_LI.linear() * I * X_LI.linear().transpose();
    body.p_WB = X_WL * X_LI.translation();
    body.q_WB = Eigen::Quaterniond(X_WL.linear()).normalized();
    if (link.collision_array.empty() && link.visual_array.empty())
      model_.remarks.push_back("link '" + link.name + "' has no geometry: no clearance to it is computed");
    model_.bodies.push_back(std::move(body));
    const int index = static_cast<int>(model_.bodies.size()) - 1;
    add_shapes(link, {index, X_WL}, get_frame(index));
    return index;
  }

  void add_joint(const std::string& name, Kind kind, int base, int follower, const Isometry3d& X_WJ) {
    ImportedJoint joint;
    joint.name = name;
    joint.line = get_line("joint", name);
    joint.kind = kind;
    joint.base = base;
    joint.follower = follower;
    joint.p_WJ = X_WJ.translation();
    joint.R_WJ = X_WJ.linear();
    model_.joints.push_back(joint);
  }

  // Collision shapes of a link, or its visual shapes if it has none.
  void add_shapes(const urdf::Link& link, const Placed& placed, const Isometry3d& X_WB) {
    std::vector<std::pair<urdf::GeometryConstSharedPtr, urdf::Pose>> list;
    for (const auto& part : link.collision_array) list.emplace_back(part->geometry, part->origin);
    if (list.empty()) {
      for (const auto& part : link.visual_array) list.emplace_back(part->geometry, part->origin);
    }
    if (placed.body < 0) {
      if (!list.empty()) model_.remarks.push_back("link '" + link.name + "': shapes of the ground are left out");
      return;
    }
    for (const auto& [geometry, origin] : list) {
      if (geometry)
        add_shape(link.name, *geometry, X_WB.inverse() * placed.X_WL * place(origin),
                  model_.bodies[static_cast<std::size_t>(placed.body)]);
    }
  }

  // False where a size is 0; any other mistake is that of the shape.
  static bool has_volume(const urdf::Geometry& geometry) {
    if (geometry.type == urdf::Geometry::SPHERE) return static_cast<const urdf::Sphere&>(geometry).radius != 0;
    if (geometry.type == urdf::Geometry::BOX) {
      const urdf::Vector3& size = static_cast<const urdf::Box&>(geometry).dim;
      return size.x != 0 && size.y != 0 && size.z != 0;
    }
    if (geometry.type != urdf::Geometry::CYLINDER) return true;
    const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
    return cylinder.radius != 0 && cylinder.length != 0;
  }

  void add_shape(const std::string& link, const urdf::Geometry& geometry, const Isometry3d& X_BS, ImportedBody& body) {
    if (++shapes_ > kMostImported) throw ImportError("it has more than " + std::to_string(kMostImported) + " shapes");
    if (!has_volume(geometry)) {
      model_.remarks.push_back(quote("link", link) +
                               " has a shape without volume, such as a box of size 0, which is left out");
      return;
    }
    geometry::Shape shape;
    shape.from = to_vec3(X_BS.translation());
    if (geometry.type == urdf::Geometry::SPHERE) {
      shape.kind = geometry::ShapeKind::kSphere;
      shape.radius = static_cast<const urdf::Sphere&>(geometry).radius;
    } else if (geometry.type == urdf::Geometry::BOX) {
      shape.kind = geometry::ShapeKind::kBox;
      shape.size = to_vec3(to_vector(static_cast<const urdf::Box&>(geometry).dim));
      shape.q_BS = to_quat(Eigen::Quaterniond(X_BS.linear()).normalized());
    } else if (geometry.type == urdf::Geometry::CYLINDER) {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
      shape.kind = geometry::ShapeKind::kCylinder;
      shape.radius = cylinder.radius;
      shape.from = to_vec3(X_BS * Eigen::Vector3d(0, 0, -0.5 * cylinder.length));
      shape.to = to_vec3(X_BS * Eigen::Vector3d(0, 0, 0.5 * cylinder.length));
    } else {
      model_.remarks.push_back("link '" + link +
                               "': a mesh is left out; a scenario can name its STL or OBJ file by `mesh`");
      return;
    }
    body.shapes.push_back(std::move(shape));
  }

  const UrdfText& text_;
  ImportedModel& model_;
  const bool fixed_base_;
  std::size_t shapes_ = 0;
  bool told_angles_ = false;
};

// "line 7: " for the joint or link that a message of urdfdom names in brackets; empty if it names none.
std::string find_line(const UrdfText& elements, const std::string& said) {
  for (const char* kind : {"joint", "link"}) {
    for (const auto& [element, line] : elements.lines) {
      if (element.first == kind && said.find("[" + element.second + "]") != std::string::npos)
        return "line " + std::to_string(line) + ": ";
    }
  }
  return "";
}

}  // namespace

ImportedModel read_urdf(const std::string& text, const std::string& path, bool fixed_base) {
  const UrdfText elements = read_urdf_text(text);
  Listener listener;
  console_bridge::useOutputHandler(&listener);
  const urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(text);
  console_bridge::restorePreviousOutputHandler();
  if (!robot || !robot->getRoot() || listener.failed) {
    throw ImportError(find_line(elements, listener.said) + "it is no URDF: " +
                      (listener.said.empty() ? "urdfdom cannot read it" : listener.said));
  }
  ImportedModel model;
  model.name = robot->getName();
  model.source = "URDF, " + path;
  model.remarks.push_back("a URDF has no gravity: 9.81 m/s2 along -z is assumed");
  model.remarks.push_back("every joint is at its zero, and nothing moves");
  model.remarks.insert(model.remarks.end(), elements.remarks.begin(), elements.remarks.end());
  Reader(elements, model, fixed_base).read(*robot);
  return model;
}

}  // namespace unlatch::tools
