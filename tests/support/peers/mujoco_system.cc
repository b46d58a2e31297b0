#include "tests/support/peers/mujoco_system.h"

#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace unlatch::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

std::ostream& operator<<(std::ostream& out, const Vector3d& v) { return out << v.x() << ' ' << v.y() << ' ' << v.z(); }
std::ostream& operator<<(std::ostream& out, const Quaterniond& q) {
  return out << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
}

// MuJoCo applies a body's joints one after the other, from the parent outwards. The sliding axes of a joint are fixed
// in its base: they come first if the base is the parent, and last if it is the child.
class Document {
 public:
  explicit Document(const Model& model) : model_(model), links_(build_tree_links(model)), children_(links_.size()) {
    for (std::size_t k = 0; k < links_.size(); ++k)
      if (links_[k].parent != kGround) children_[static_cast<std::size_t>(links_[k].parent)].push_back(k);
    out_.precision(17);
    // boundmass, balanceinertia and similar options stay off: masses are used unchanged.
    const std::vector<int> closing = list_closing_joints(model);
    const char* const flags = closing.empty() ? "constraint='disable' equality='disable'" : "";
    out_ << "<mujoco><compiler angle='radian'/><size njmax='" << kMostRows * closing.size() + 1
         << "' nconmax='1'/><option gravity='" << model.gravity.uniform << "' iterations='100' tolerance='1e-12'>"
         << "<flag contact='disable' " << flags << "/></option><worldbody>";
    for (const TreeLink& link : links_)
      if (link.parent == kGround) write_body(link);
    out_ << "</worldbody><equality>";
    for (const int j : closing) write_closing(get_closing_joint(model, j));
    out_ << "</equality></mujoco>";
  }
  std::string get_text() const { return out_.str(); }
  const std::vector<double>& get_speeds() const { return speeds_; }  // in the order of qvel

 private:
  static constexpr std::size_t kMostRows = 6;

  // A hinge is two points on its axis, as MuJoCo has none: six rows for five. `solimp` as hard as it allows: rows yield
  // by 1e-4 of what they bear.
  void write_closing(const ClosingJoint& closing) {
    constexpr double kApart = 0.1;  // m
    const int to = closing.base == kGround ? closing.follower : closing.base;
    const Placement body = get_placement(model_, to);
    const auto write = [&](const char* kind, const Vector3d& point) {
      out_ << '<' << kind << " body1='" << to << "'";
      if (closing.base != kGround) out_ << " body2='" << closing.follower << "'";
      if (point.allFinite()) out_ << " anchor='" << Vector3d(body.R.transpose() * (point - body.p)) << "'";
      out_ << " solimp='0.9999 0.9999 0.001 0.5 2'/>";
    };
    if (closing.weld) return write("weld", Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    write("connect", closing.point - kApart * closing.hinge.col(2));
    write("connect", closing.point + kApart * closing.hinge.col(2));
  }

  void write_body(const TreeLink& link) {
    const Body& body = model_.bodies[static_cast<std::size_t>(link.body)];
    const Placement parent = get_placement(model_, link.parent);
    const Quaterniond q_parent(parent.R);
    out_ << "<body name='" << link.body << "' pos='" << Vector3d(q_parent.conjugate() * (body.p_WB - parent.p))
         << "' quat='" << q_parent.conjugate() * Quaterniond(body.q_WB.normalized()) << "'>";
    if (link.joint == kNone) {
      out_ << "<freejoint/>";  // speeds: linear in world axes, angular in the body's
      speeds_.insert(speeds_.end(), body.v_WB.begin(), body.v_WB.end());
      speeds_.insert(speeds_.end(), body.w_WB_B.begin(), body.w_WB_B.end());
    } else {
      write_joint(link, get_placement(model_, link.body));
    }
    // Principal axes from Eigen: MuJoCo's own diagonalisation is accurate to 1e-9 only.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(body.inertia);
    Eigen::Matrix3d axes = principal.eigenvectors();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    out_ << "<inertial pos='0 0 0' quat='" << Quaterniond(axes) << "' mass='" << body.mass << "' diaginertia='"
         << Vector3d(principal.eigenvalues()) << "'/>";
    for (const std::size_t child : children_[static_cast<std::size_t>(link.body)]) write_body(links_[child]);
    out_ << "</body>";
  }

  void write_joint(const TreeLink& link, const Placement& child) {
    const Freedoms f = calc_freedoms(model_, model_.joints[static_cast<std::size_t>(link.joint)]);
    const double sign = link.child_is_follower ? 1 : -1;  // sign of the child's motion relative to the follower's
    if (link.child_is_follower) write_slides(f, child, sign);
    write_turns(f, child, sign, !link.child_is_follower);
    if (!link.child_is_follower) write_slides(f, child, sign);
  }

  void write_slides(const Freedoms& f, const Placement& child, double sign) {
    for (std::size_t k = 0; k < f.slides.size(); ++k)
      write_axis("slide", f, f.slides[k], child, sign * f.slide_speeds[k]);
  }

  void write_turns(const Freedoms& f, const Placement& child, double sign, bool reversed) {
    if (f.turns.size() == 3) {
      out_ << "<joint type='ball' pos='" << Vector3d(child.R.transpose() * (f.point - child.p)) << "'/>";
      Vector3d w = Vector3d::Zero();
      for (std::size_t k = 0; k < 3; ++k) w += sign * f.turn_speeds[k] * f.turns[k];
      const Vector3d w_child = child.R.transpose() * w;
      speeds_.insert(speeds_.end(), w_child.begin(), w_child.end());
      return;
    }
    for (std::size_t i = 0; i < f.turns.size(); ++i) {
      const std::size_t k = reversed ? f.turns.size() - 1 - i : i;
      write_axis("hinge", f, f.turns[k], child, sign * f.turn_speeds[k]);
    }
  }

  void write_axis(const char* type, const Freedoms& f, const Vector3d& axis, const Placement& child, double speed) {
    out_ << "<joint type='" << type << "' pos='" << Vector3d(child.R.transpose() * (f.point - child.p)) << "' axis='"
         << Vector3d(child.R.transpose() * axis) << "'/>";
    speeds_.push_back(speed);
  }

  const Model& model_;
  std::vector<TreeLink> links_;
  std::vector<std::vector<std::size_t>> children_;  // per body: links
  std::ostringstream out_;
  std::vector<double> speeds_;
};

mjModel* load(const std::string& text) {
  const auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  const char* const name = "model.xml";
  mj_makeEmptyFileVFS(vfs.get(), name, static_cast<int>(text.size()));
  text.copy(static_cast<char*>(vfs->filedata[0]), text.size());
  char error[1000] = "";
  mjModel* model = mj_loadXML(name, vfs.get(), error, sizeof(error));
  mj_deleteVFS(vfs.get());
  if (model == nullptr) throw std::runtime_error(std::string("MuJoCo: ") + error);
  return model;
}

}  // namespace

struct MujocoSystem::Data {
  std::unique_ptr<mjModel, Deleter> model;
  std::unique_ptr<mjData, Deleter> data;
  std::vector<int> numbers;  // MuJoCo's numbers of the bodies
  Vector3d gravity;
};

MujocoSystem::MujocoSystem(const Model& model, const std::vector<Wrench>& wrenches) : data_(std::make_unique<Data>()) {
  const Document document(model);
  data_->model.reset(load(document.get_text()));
  data_->data.reset(mj_makeData(data_->model.get()));
  data_->gravity = model.gravity.uniform;
  if (document.get_speeds().size() != static_cast<std::size_t>(data_->model->nv))
    throw std::logic_error("MuJoCo counts freedoms differently");
  std::copy(document.get_speeds().begin(), document.get_speeds().end(), data_->data->qvel);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    data_->numbers.push_back(mj_name2id(data_->model.get(), mjOBJ_BODY, std::to_string(b).c_str()));
  for (std::size_t b = 0; b < wrenches.size(); ++b) {
    double* applied = data_->data->xfrc_applied + 6 * data_->numbers[b];
    Vector3d::Map(applied) = wrenches[b].force;
    Vector3d::Map(applied + 3) = wrenches[b].torque;
  }
}

MujocoSystem::~MujocoSystem() = default;

void MujocoSystem::solve() { mj_forward(data_->model.get(), data_->data.get()); }

// Accelerations by MuJoCo are relative to a world that accelerates upwards in place of gravity.
BodyAccelerations MujocoSystem::calc_accelerations() {
  mj_rnePostConstraint(data_->model.get(), data_->data.get());
  BodyAccelerations out;
  for (const int number : data_->numbers) {
    double a[6];  // angular, linear
    mj_objectAcceleration(data_->model.get(), data_->data.get(), mjOBJ_BODY, number, a, 0);
    out.angular.push_back(Vector3d::Map(a));
    out.linear.push_back(Vector3d::Map(a + 3) + data_->gravity);
  }
  return out;
}

}  // namespace unlatch::test
