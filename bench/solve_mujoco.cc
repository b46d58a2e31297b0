// MuJoCo's mj_forward() on the same tree, written as an MJCF document without shapes, contacts or actuators.
#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <sstream>
#include <stdexcept>

#include "bench/solve_solver.h"

namespace unlatch::bench {
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

class Document {
 public:
  explicit Document(const Model& model) : model_(model), children_(model.bodies.size()) {
    for (const Joint& joint : model.joints) children_[static_cast<std::size_t>(joint.base)].push_back(&joint);
    out_.precision(17);
    // boundmass, balanceinertia and the like stay off: masses are taken as they are.
    out_ << "<mujoco><compiler angle='radian'/><size njmax='1' nconmax='1'/><option gravity='" << model.gravity.uniform
         << "'><flag contact='disable' constraint='disable' equality='disable'/></option><worldbody>";
    write_body(0, nullptr);
    out_ << "</worldbody></mujoco>";
  }
  std::string get_text() const { return out_.str(); }

 private:
  void write_body(int index, const Joint* joint) {
    const Body& body = model_.bodies[static_cast<std::size_t>(index)];
    Vector3d p = body.p_WB;
    Quaterniond q = body.q_WB;
    if (joint != nullptr) {
      const Body& base = model_.bodies[static_cast<std::size_t>(joint->base)];
      p = base.q_WB.conjugate() * (body.p_WB - base.p_WB);
      q = base.q_WB.conjugate() * body.q_WB;
    }
    out_ << "<body pos='" << p << "' quat='" << q << "'>";
    if (joint == nullptr) {
      out_ << "<freejoint/>";
    } else {
      const Vector3d axis = q.conjugate() * joint->axes.col(2);
      out_ << "<joint type='hinge' pos='" << joint->point_follower << "' axis='" << axis << "'/>";
    }
    // Principal axes from Eigen: MuJoCo's own diagonalisation is good for 1e-9 only.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(body.inertia);
    Eigen::Matrix3d axes = principal.eigenvectors();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    out_ << "<inertial pos='0 0 0' quat='" << Quaterniond(axes) << "' mass='" << body.mass << "' diaginertia='"
         << Vector3d(principal.eigenvalues()) << "'/>";
    for (const Joint* child : children_[static_cast<std::size_t>(index)]) write_body(child->follower, child);
    out_ << "</body>";
  }

  const Model& model_;
  std::vector<std::vector<const Joint*>> children_;
  std::ostringstream out_;
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

class MuJoCo final : public Solver {
 public:
  explicit MuJoCo(const Model& model)
      : model_(model), mj_model_(load(Document(model).get_text())), mj_data_(mj_makeData(mj_model_.get())) {
    // Free joint: linear velocity in world axes, angular in body axes; then one speed a hinge. A hinge's coordinate
    // stands where its joint does in the document, which is found by its body.
    const Body& root = model.bodies[0];
    Vector3d::Map(mj_data_->qvel) = root.v_WB;
    Vector3d::Map(mj_data_->qvel + 3) = root.w_WB_B;
    number_bodies(0);
    for (const Joint& joint : model.joints) {
      const Body& base = model.bodies[static_cast<std::size_t>(joint.base)];
      const Body& follower = model.bodies[static_cast<std::size_t>(joint.follower)];
      const Vector3d w = follower.q_WB * follower.w_WB_B - base.q_WB * base.w_WB_B;
      mj_data_->qvel[get_address(joint.follower)] = w.dot(base.q_WB * joint.axes.col(2));
    }
  }

  void solve() override { mj_forward(mj_model_.get(), mj_data_.get()); }

  Solution build_solution() const override {
    const double* a = mj_data_->qacc;
    const Vector3d angular = model_.bodies[0].q_WB * Vector3d::Map(a + 3);
    Solution solution{{a[0], a[1], a[2], angular.x(), angular.y(), angular.z()}, {}};
    for (const Joint& joint : model_.joints) solution.accelerations.push_back(a[get_address(joint.follower)]);
    return solution;
  }

 private:
  // MuJoCo numbers bodies depth first, as they stand in the document; the world is 0.
  void number_bodies(int root) {
    std::vector<std::vector<int>> children(model_.bodies.size());
    for (const Joint& joint : model_.joints) children[static_cast<std::size_t>(joint.base)].push_back(joint.follower);
    numbers_.resize(model_.bodies.size());
    std::vector<int> stack{root};
    for (int next = 1; !stack.empty(); ++next) {
      const auto body = static_cast<std::size_t>(stack.back());
      stack.pop_back();
      numbers_[body] = next;
      stack.insert(stack.end(), children[body].rbegin(), children[body].rend());
    }
  }
  int get_address(int body) const { return mj_model_->body_dofadr[numbers_[static_cast<std::size_t>(body)]]; }

  Model model_;
  std::unique_ptr<mjModel, Deleter> mj_model_;
  std::unique_ptr<mjData, Deleter> mj_data_;
  std::vector<int> numbers_;
};

}  // namespace

std::unique_ptr<Solver> build_mujoco(const Model& model) { return std::make_unique<MuJoCo>(model); }

}  // namespace unlatch::bench
